// Held-out recordings have the last word: an explanation that does not hold in them is not named.

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;

namespace {

/// A pendulum with dry friction, a spring and a torque that ripples with speed, by steps of 0.1 ms of its own
/// equations, sampled at 50 Hz for 12 s.
std::string recorded(double friction, double spring, double start, std::uint64_t seed, double ripple = 0.0) {
  constexpr double kStep = 1e-4;
  RandomStream random(seed);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u\n";
  double q = start, v = 0.0;
  for (int k = 0; k < 600; ++k) {
    const double t = 0.02 * k, u = 1.5 * std::sin(1.3 * t) + std::sin(4.1 * t + start);
    csv << t << "," << q + 5e-4 * draw_normal(random) << "," << u << "\n";
    for (int i = 0; i < 200; ++i) {
      v += kStep * (u - 9.81 * std::sin(q) - 0.2 * v - friction * std::tanh(v / 1e-3) - spring * q -
                    ripple * std::sin(4.0 * v));
      q += kStep * v;
    }
  }
  return csv.str();
}

/// The diagnosis of a machine with dry friction of 0.2 and no spring, and its held-out recording.
Diagnosis diagnosed(double friction, double spring) {
  const io_examples::Folder folder;
  write_file(folder.path() / "a.csv", recorded(0.2, 0.0, 0.4, 1));
  write_file(folder.path() / "b.csv", recorded(0.2, 0.0, -0.7, 2));
  write_file(folder.path() / "held.csv", recorded(friction, spring, 0.9, 3));
  write_file(folder.path() / "spec.yaml",
             "name: held\nmodel: {plant: pendulum, parameters: {mass: 1, length: 1, friction: 0.2}}\n"
             "signals: {time: t, position: q, input: u}\nrecordings: [a.csv, b.csv]\nheld_out: [held.csv]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

}  // namespace

TEST_CASE("An explanation that held-out recordings contradict is not named, and no effect of it is certain",
          "[diagnose][slow]") {
  const Diagnosis same = diagnosed(0.2, 0.0);
  CHECK(same.verdict == Verdict::named);
  CHECK(same.reason.empty());
  CHECK(same.explanation.effects.at(0).inclusion.value() > 0.9);
  for (const auto& [friction, spring] : {std::pair{0.5, 0.0}, {0.2, 3.0}}) {
    INFO("held out: friction " << friction << ", spring " << spring);
    const Diagnosis other = diagnosed(friction, spring);
    CHECK(other.verdict == Verdict::unknown);
    CHECK_THAT(other.reason, Catch::Contains("held-out recordings contradict"));
    REQUIRE(other.explanation.effects.size() == same.explanation.effects.size());  // what was found is still listed,
    for (const ExplainedEffect& effect : other.explanation.effects) CHECK(effect.inclusion.value() <= 0.7);  // doubted
    for (const auto& [name, p] : other.inclusion.items) CHECK(p <= 0.7);
    CHECK(other.explanation.probability <= 0.7);
  }
  // A little wear, of less than a tenth of the error, is none.
  CHECK(diagnosed(0.205, 0.0).verdict == Verdict::named);
}

TEST_CASE("A remainder that makes held-out recordings worse is dropped", "[diagnose][slow]") {
  const auto models = [](double held_out) {  // of a machine whose ripple is gone in what is held out, or is not
    const io_examples::Folder folder;
    write_file(folder.path() / "a.csv", recorded(0.2, 0.0, 0.4, 1, 0.8));
    write_file(folder.path() / "b.csv", recorded(0.2, 0.0, -0.7, 2, 0.8));
    write_file(folder.path() / "held.csv", recorded(0.2, 0.0, 0.9, 3, held_out));
    write_file(folder.path() / "spec.yaml",
               "name: held\nmodel: {plant: pendulum, parameters: {mass: 1, length: 1, friction: 0.2}}\n"
               "effects: [coulomb_friction]\nsignals: {time: t, position: q, input: u}\n"
               "recordings: [a.csv, b.csv]\nheld_out: [held.csv]\n");
    return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml"));
  };
  const Diagnosed same = models(0.8), gone = models(0.0);
  CHECK(same.diagnosis.verdict == Verdict::unknown);
  CHECK(same.model["model"].contains("remainder"));
  CHECK(same.diagnosis.fit.held_out.after.value() < 0.7 * same.diagnosis.fit.held_out.before.value());
  CHECK(gone.diagnosis.verdict == Verdict::unknown);
  CHECK_FALSE(gone.model["model"].contains("remainder"));
}
