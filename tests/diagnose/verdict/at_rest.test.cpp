// Machines that are let go and come to rest where dry friction holds them, in one short recording without an input:
// what they do while they stand says as much as what they do while they move. Integrated here, independently.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;
using Catch::Matchers::VectorContains;

namespace {

/// A joint under `drive`, which friction of `sliding(v)` slows down and, below `holding`, stops.
struct Rubbing {
  std::function<double(double q, double v)> drive;
  std::function<double(double v)> sliding;
  double holding = 0.0;
};

/// Positions at 51 Hz for 10 s: semi-implicit steps of 20 us, at rest while the drive stays below what holds.
std::string recorded(const Rubbing& joint, double q, double v, double noise, std::uint64_t seed) {
  constexpr double kStep = 2e-5, kPeriod = 1.0 / 51.0;
  RandomStream random(seed);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u\n";
  double t = 0.0;
  for (int k = 0; k < 510; ++k) {
    csv << kPeriod * k << "," << q + noise * draw_normal(random) << ",0\n";
    for (; t < kPeriod * (k + 1); t += kStep) {
      const double force = joint.drive(q, v);
      if (v == 0.0 && std::abs(force) <= joint.holding) continue;
      const double against = v != 0.0 ? std::copysign(joint.sliding(v), v) : std::copysign(joint.holding, force);
      const double next = v + kStep * (force - against);
      v = v * next < 0.0 ? 0.0 : next;
      q += kStep * v;
    }
  }
  return csv.str();
}

Diagnosis diagnosed(const std::string& acceleration, const Rubbing& joint, double noise) {
  const io_examples::Folder folder;
  write_file(folder.path() / "train.csv", recorded(joint, 1.3, 0.0, noise, 1));
  write_file(folder.path() / "test.csv", recorded(joint, -1.1, 0.4, noise, 2));
  write_file(folder.path() / "spec.yaml",
             "name: at_rest\nmodel: {plant: custom, parameters: {k: 1.0}, acceleration: [\"" + acceleration +
                 "\"]}\nsignals: {time: t, position: [q], input: [u]}\nrecordings: [train.csv]\n"
                 "held_out: [test.csv]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

const Estimate& parameter_of(const Diagnosis& diagnosis, const std::string& name) {
  for (const ExplainedEffect& effect : diagnosis.explanation.effects) {
    if (const Estimate* found = effect.parameters.find(name)) return *found;
  }
  throw std::out_of_range(name);
}

}  // namespace

TEST_CASE("Coulomb friction that holds a swing off its lowest point is named with its level", "[diagnose][rest]") {
  for (const double noise : {0.0, 0.01, 0.02}) {
    INFO("noise " << noise);
    const Rubbing joint{[](double q, double) { return -std::sin(q); }, [](double) { return 0.15; }, 0.15};
    const Diagnosis diagnosis = diagnosed("-k*sin(q)", joint, noise);
    INFO(to_json(diagnosis).dump(1));
    CHECK(diagnosis.verdict == Verdict::named);
    REQUIRE(diagnosis.explanation.effects.size() == 1);
    CHECK(diagnosis.explanation.effects[0].name == "coulomb_friction");
    const Estimate& level = parameter_of(diagnosis, "level");
    CHECK(std::abs(level.value - 0.15) < 4.0 * level.sd + 2e-4);
    CHECK(*diagnosis.explanation.effects[0].inclusion > 0.9);
    CHECK(*diagnosis.explanation.effects[0].share == Approx(1.0).margin(1e-9));
  }
}

TEST_CASE("A spring beside the friction that holds it out of balance is named with it", "[diagnose][rest]") {
  for (const double noise : {0.0, 0.01}) {
    INFO("noise " << noise);
    const Rubbing joint{[](double q, double) { return -1.6 * q; }, [](double) { return 0.3; }, 0.3};
    const Diagnosis diagnosis = diagnosed("-k*q", joint, noise);
    INFO(to_json(diagnosis).dump(1));
    REQUIRE(diagnosis.explanation.effects.size() == 2);
    for (const ExplainedEffect& effect : diagnosis.explanation.effects) CHECK(*effect.share > 0.05);
    CHECK(std::abs(parameter_of(diagnosis, "level").value - 0.3) < 4.0 * parameter_of(diagnosis, "level").sd + 5e-4);
    CHECK(std::abs(parameter_of(diagnosis, "stiffness").value - 0.6) <
          4.0 * parameter_of(diagnosis, "stiffness").sd + 5e-4);
  }
}

TEST_CASE("A spring that is stronger than the model's is physics, and as credible as a weak one", "[diagnose][rest]") {
  for (const double stronger : {0.2, 1.5, 3.0}) {
    INFO("by " << stronger);
    const Rubbing joint{[&](double q, double v) { return -std::sin(q) - stronger * q - 0.05 * v; },
                        [](double) { return 0.0; }};
    const Diagnosis diagnosis = diagnosed("-k*sin(q) - 0.05*v", joint, 0.01);
    INFO(to_json(diagnosis).dump(1));
    CHECK(diagnosis.verdict == Verdict::named);
    REQUIRE(diagnosis.explanation.effects.size() == 1);
    CHECK(diagnosis.explanation.effects[0].name == "linear_spring");
    CHECK(std::abs(parameter_of(diagnosis, "stiffness").value - stronger) <
          4.0 * parameter_of(diagnosis, "stiffness").sd);
  }
}
