#include <catch2/catch.hpp>

#include "support/compare.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// Processes so sure of their means that nothing is ever learned.
std::string certain(int dimension, const std::string& model) {
  std::string scales = "1";
  for (int i = 1; i < dimension; ++i) scales += ", 1";
  const std::string process =
      "{kernel: {type: squared_exponential, output_scale: 1e-6, length_scales: [" + scales + "]}}";
  return "belief={drift: " + process + ", input_gain: " + process + ", coupling: " + process +
         ", prior_model: " + model + "}";
}

/// A variance of 1e-12 of log b multiplies E b by exp(5e-13); the loop carries that on.
constexpr double kTight = 1e-9;

}  // namespace

TEST_CASE("With the true model as prior mean and no doubt, SP1 is the oracle", "[experiment]") {
  const Study study = slide({certain(2, "{plant: mass, parameters: {mass: 2, friction: 0.5}}")});
  const StudyOutcome outcome = run_one(study);
  CHECK(metric(outcome, "SP1", "drift_points") + metric(outcome, "SP1", "gain_points") == 0);
  for (const char* name : {"energy", "squared_error", "final_angle", "peak_input"}) {
    INFO(name);
    CHECK(relative_error(metric(outcome, "SP1", name), metric(outcome, "oracle", name)) < kTight);
  }
}

TEST_CASE("With the true model of a two-link arm as prior mean, SP1 is the oracle too", "[experiment]") {
  const Study study = slide({certain(4, "{plant: two_link_arm}"), "model={plant: two_link_arm}",
                             "initial_state={position: [0.3, 0.4], velocity: [0, 0]}",
                             "reference={type: setpoint, position: [1, -0.5]}"});
  const StudyOutcome outcome = run_one(study);
  for (const char* name : {"energy", "squared_error", "final_angle", "peak_input"}) {
    INFO(name);
    CHECK(relative_error(metric(outcome, "SP1", name), metric(outcome, "oracle", name)) < kTight);
  }
}

TEST_CASE("With a wrong model as prior mean and no doubt, SP1 is not the oracle", "[experiment]") {
  const Study study = slide({certain(2, "{plant: mass, parameters: {mass: 2.2, friction: 0.5}}")});
  const StudyOutcome outcome = run_one(study);
  CHECK(relative_error(metric(outcome, "SP1", "energy"), metric(outcome, "oracle", "energy")) > 0.01);
}
