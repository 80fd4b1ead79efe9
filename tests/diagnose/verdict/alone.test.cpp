// What recordings of one stroke leave open: every law that acts alike there is told, and none as certain.

#include <catch2/catch.hpp>
#include <cmath>
#include <set>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "diagnose/verdict/sentence.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;

namespace {

/// A slide of 1 kg with dry friction of 2 N and a torque that no law tells, 0.1 N for about 0.1 s, by a servo that
/// follows q = wanted(t), at 100 Hz for 8 s.
std::string stroke(double (*wanted)(double)) {
  constexpr double kStep = 1e-4;
  RandomStream random(5);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u\n";
  double q = wanted(0.0), v = (wanted(kStep) - wanted(0.0)) / kStep, wandering = 0.0;
  for (int k = 0; k < 800; ++k) {
    const double t = 0.01 * k, speed = (wanted(t + kStep) - wanted(t)) / kStep;
    const double u = 2.0 * std::tanh(speed / 0.02) + 400.0 * (wanted(t) - q) + 40.0 * (speed - v);
    csv << t << "," << q + 1e-5 * draw_normal(random) << "," << u << "\n";
    for (int i = 0; i < 100; ++i) {
      wandering += -kStep / 0.1 * wandering + 0.1 * std::sqrt(2.0 * kStep / 0.1) * draw_normal(random);
      v += kStep * (u - 2.0 * std::tanh(v / 1e-3) + wandering);
      q += kStep * v;
    }
  }
  return csv.str();
}

Diagnosis diagnosed(double (*wanted)(double)) {
  const io_examples::Folder folder;
  write_file(folder.path() / "a.csv", stroke(wanted));
  write_file(folder.path() / "spec.yaml",
             "name: stroke\nmodel: {plant: mass, parameters: {mass: 1}}\n"
             "signals: {time: t, position: q, input: u}\nrecordings: [a.csv]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

std::set<std::string> names(const std::optional<Alone>& alone) {
  std::set<std::string> result;
  if (alone) {
    for (const auto& [name, share] : alone->effects.items) result.insert(name);
  }
  return result;
}

}  // namespace

TEST_CASE("One stroke one way leaves open which law it is, and says so", "[diagnose][slow]") {
  const Diagnosis d = diagnosed([](double t) { return t < 1.0 ? 0.2 * t * t : 0.4 * t - 0.2; });
  CHECK((d.verdict == Verdict::unknown || d.verdict == Verdict::ambiguous));
  CHECK_FALSE(has_certain(d));
  REQUIRE(d.alone);
  CHECK(d.alone->one_way);
  const std::set<std::string> open = names(d.alone);
  for (const char* law :
       {"coulomb_friction", "constant_bias", "viscous_friction", "quadratic_drag", "input_dead_zone"}) {
    INFO(law);
    CHECK(open.contains(law));
  }
  CHECK_FALSE(open.contains("linear_spring"));  // which grows along the way
  CHECK_THAT(sentence(d), Catch::Contains("moves one way only"));
}

// Its motion is also that of a spring and a shaking under no input at all, which no sensor's noise contradicts.
TEST_CASE("The same machine to and fro tells dry friction from a bias and from drag", "[diagnose][slow]") {
  const Diagnosis d = diagnosed([](double t) { return 0.4 * std::sin(t) + 0.1 * std::sin(2.7 * t); });
  const std::set<std::string> open = names(d.alone);
  CHECK_FALSE(open.contains("constant_bias"));
  CHECK_FALSE(open.contains("quadratic_drag"));
  REQUIRE(d.explanation.effects.size() > 0);
  CHECK(d.explanation.effects[0].name == "coulomb_friction");
}
