// A failed run is a row, not a hole.

#include <catch2/catch.hpp>
#include <cmath>

#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

LoopResult run_failing(const LoopSetup& setup) { return run_loop(setup, random_stream(1, "failure")); }

/// A slide under an inner law far too stiff for its control period: the velocity grows 999-fold in each step.
LoopSetup exploding() {
  LoopSetup setup = example_setup(Mass{}, Oracle{}, 5.0);
  setup.inner_law = {1.0, 1e5};
  return setup;
}

}  // namespace

TEST_CASE("A diverging run fails with its reason and keeps the steps until then", "[sim]") {
  const LoopResult result = run_failing(exploding());
  CHECK(result.status == RunStatus::failed);
  CHECK_THAT(result.reason, Catch::Contains("the state diverges at t = "));
  REQUIRE(result.steps.size() > 10);
  CHECK(result.steps.size() < 501);
  for (const LoopStep& step : result.steps) {
    REQUIRE(std::isfinite(step.position[0]));
    REQUIRE(std::isfinite(step.input[0]));
  }
  CHECK(std::abs(result.steps.back().velocity[0]) > 1e100);
}

TEST_CASE("A failed run does what the same run did up to there", "[sim]") {
  LoopSetup setup = exploding();
  const LoopResult failed = run_failing(setup);
  setup.duration = 0.1;
  const LoopResult whole = run_failing(setup);
  REQUIRE(whole.status == RunStatus::ok);
  for (std::size_t k = 0; k + 1 < whole.steps.size(); ++k) CHECK(whole.steps[k].position == failed.steps[k].position);
}

TEST_CASE(
    "An initial state that is not finite fails on every plant under every controller, at once and without a throw",
    "[sim]") {
  for (const auto& [name, controller] : example_controllers()) {
    for_each_alternative(
        static_cast<Plant*>(nullptr), [&, n = name, c = controller]<class PlantType>(const PlantType& plant) {
          for (const double value :
               {static_cast<double>(NAN), static_cast<double>(INFINITY), -static_cast<double>(INFINITY)}) {
            for (Eigen::Index i = 0; i < 2 * example_joints<PlantType>; ++i) {
              LoopSetup setup = example_setup(plant, c, 1.0);
              setup.initial_state[i] = value;
              const LoopResult result = run_failing(setup);
              INFO(n << " on " << PlantType::kName << ", x[" << i << "] = " << value);
              CHECK(result.status == RunStatus::failed);
              CHECK_FALSE(result.reason.empty());
              CHECK(result.steps.size() <= 1);
            }
          }
        });
  }
}

TEST_CASE("A run whose samples repeat without noise skips them and goes on", "[sim]") {
  // A slide at rest at its goal is asked about the same state again and again.
  LoopSetup setup = example_setup(Mass{}, Adaptive{}, 2.0);
  BeliefPrior prior = example_prior(1);
  prior.drift[0].noise_variance = 0.0;
  setup.belief = Belief(prior, 1);
  setup.initial_state.setZero();
  setup.reference = Setpoint{{0.0}};
  setup.learner.period = 0.1;
  setup.learner.drift_threshold = 1e-300;
  const LoopResult result = run_failing(setup);
  CHECK(result.status == RunStatus::ok);
  CHECK(result.belief.drift(0).predict(std::vector<double>{0.0, 0.0}).variance == Approx(0.0).margin(1e-12));
  for (const LoopStep& step : result.steps) CHECK(std::isfinite(step.input[0]));
}

TEST_CASE("Too few integration steps fail with the time", "[sim]") {
  LoopSetup setup = example_setup(Pendulum{}, Proportional{100.0}, 1.0);
  setup.integration.max_steps = 1;
  setup.integration.relative_tolerance = setup.integration.absolute_tolerance = 1e-14;
  const LoopResult result = run_failing(setup);
  CHECK(result.status == RunStatus::failed);
  CHECK_THAT(result.reason, Catch::Contains("the integration stalls at t = "));
}
