// What the tests of residuals say of white noise, of missing physics, of a change in time and of a closed loop.

#include "diagnose/verdict/residual_tests.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "physics/machine/simulation.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::record;

namespace {

constexpr double kRare = 0.01;  // p-value

/// Tests of what the nominal and the best explanation leave.
struct Tested {
  ResidualTests nominal, best;
};
Tested test(const std::vector<Measured>& data) {
  const ExplainOptions options{usual_effects(), {}};
  const Explanation found = explain(kPendulum, data, options);
  const Linearisation& about = *found.linearisation;
  const FitProblem problem = problem_about(about, found, data, options);
  const std::vector<ResidualTests> results =
      residual_tests(about, data, found.noise,
                     {residuals(problem, found.without_effects().fit), residuals(problem, found.best().fit)});
  return {results[0], results[1]};
}

/// A pendulum that follows a sine by its measured position.
Measured closed_loop(std::uint64_t seed) {
  RandomStream random(seed);
  const Machine machine(kPendulum, {});
  StateVector start(2);
  start << 0.1, 0.0;
  Simulation loop(machine, start, 0.0);
  Measured data{"loop", {}, Eigen::MatrixXd(1200, 1), Eigen::MatrixXd(1200, 1), 0.0, false};
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.01 * k, shown = loop.state()[0] + 1e-2 * draw_normal(random);
    data.time.push_back(t);
    data.position(k, 0) = shown;
    data.input(k, 0) = 40.0 * (0.3 * std::sin(1.3 * t) + 0.1 * std::sin(4.1 * t) - shown);
    loop.hold(JointVector::Constant(1, data.input(k, 0)));
    loop.advance(t + 0.01);
  }
  return data;
}

}  // namespace

TEST_CASE("A perfect model leaves white noise", "[diagnose][residual][slow]") {
  const Machine machine(kPendulum, {});
  for (const std::uint64_t seed : {11, 12, 13}) {
    const ResidualTests left = test({record(machine, -1.0, seed), record(machine, 5.0, seed + 100)}).best;
    INFO("seed " << seed);
    CHECK(left.slow_p > kRare);
    CHECK(left.autocorrelation_p > kRare);
    CHECK(left.input.p > kRare);
    CHECK(left.feedback.p > kRare);
    CHECK(left.change_p > kRare);
    CHECK(left.slow_share == Approx(1.0).margin(0.35));
  }
}

TEST_CASE("Missing physics shows in what the nominal leaves and not in what the explanation leaves",
          "[diagnose][residual][slow]") {
  const EffectForm hidden = GENERATE(EffectForm(InputGain{1.05}), EffectForm(CoulombFriction{0.1}));
  const Machine machine(kPendulum, {{hidden, 0, -1}});
  const Tested tested = test({record(machine, -1.0, 21), record(machine, -1.0, 22)});
  INFO("slow share " << tested.nominal.slow_share << ", " << tested.best.slow_share);
  CHECK(tested.nominal.slow_p < kRare);
  CHECK(tested.nominal.autocorrelation_p < kRare);
  CHECK(tested.nominal.input.p < kRare);
  CHECK(tested.best.slow_p > kRare);
  CHECK(tested.best.autocorrelation_p > kRare);
  CHECK(tested.best.input.p > kRare);
}

TEST_CASE("A torque that begins late shows as a change, and when", "[diagnose][residual]") {
  const Machine machine(kPendulum, {{TorqueStep{0.15, 8.0}, 0, -1}});
  const ResidualTests left = test({record(machine, -1.0, 31)}).nominal;
  CHECK(left.change_p < kRare);
  CHECK(left.change_time == Approx(8.0).margin(1.0));
}

TEST_CASE("In a closed loop the input follows the noise: feedback, not missing physics", "[diagnose][residual]") {
  const ResidualTests left = test({closed_loop(41), closed_loop(42)}).best;
  CHECK(left.feedback.p < kRare);
  CHECK(left.feedback.lag <= 0.0);
  CHECK(left.input.p > kRare);
  CHECK(left.slow_p > kRare);
}
