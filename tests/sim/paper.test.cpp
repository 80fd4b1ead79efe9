// The parts of the paper's Table 2 that depend on no prior: the proportional baselines, and the oracle, which bounds
// what any learner can reach.

#include "support/paper.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "support/compare.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kPi = std::numbers::pi;

LoopResult run_paper(const LoopSetup& setup) {
  const LoopResult result = run_loop(setup, random_stream(1, "paper"));
  REQUIRE(result.status == RunStatus::ok);
  return result;
}

LoopResult proportional(int experiment, double gain) {
  return run_paper(paper_experiment(experiment, Proportional{gain}));
}

}  // namespace

TEST_CASE("P1 has the energies and errors of the paper's Table 2", "[sim][paper]") {
  struct Row {
    int experiment;
    double energy, error;
  };
  for (const Row& row : {Row{1, 134, 137}, Row{2, 552, 139}, Row{3, 730, 184}}) {
    const LoopResult result = proportional(row.experiment, 1.0);
    INFO("experiment " << row.experiment << ": " << result.energy << ", " << result.squared_error);
    CHECK(std::round(result.energy) == row.energy);
    CHECK(std::round(result.squared_error) == row.error);
  }
}

TEST_CASE("P100 has the errors of the paper's Table 2 and reaches the goal", "[sim][paper]") {
  for (const int experiment : {1, 2, 3}) {
    const LoopResult result = proportional(experiment, 100.0);
    INFO("experiment " << experiment << ": " << result.squared_error);
    CHECK(std::round(result.squared_error) == 10.0);
    // Proportional control leaves a droop: 100 w1 (pi - q) carries the weight m g l sin q.
    CHECK(std::abs(result.steps.back().position[0] - kPi) < 0.25);
  }
}

TEST_CASE("P100 has the energies to which the integration converges", "[sim][paper]") {
  // Converged values; the paper's 644 and 11942 are sums over its own output times, see docs.
  constexpr double kPrinted = 1e-4;  // one digit behind the point
  constexpr double kConverged = 1e-6;
  for (const auto& [experiment, energy] : {std::pair{1, 703.2}, std::pair{2, 12198.5}, std::pair{3, 12198.5}}) {
    LoopSetup setup = paper_experiment(experiment, Proportional{100.0});
    setup.integration = {.relative_tolerance = 1e-8, .absolute_tolerance = 1e-10};
    const double usual = run_paper(setup).energy;
    setup.integration = {.relative_tolerance = 1e-12, .absolute_tolerance = 1e-12};
    const double tight = run_paper(setup).energy;
    INFO("experiment " << experiment << ": " << usual << ", " << tight);
    CHECK(relative_error(usual, tight) < kConverged);
    CHECK(relative_error(tight, energy) < kPrinted);
  }
}

TEST_CASE("The oracle reaches the goal with the least that the paper's settings allow", "[sim][paper]") {
  constexpr double kTolerance = 3e-3;
  struct Row {
    int experiment;
    double energy, error;
  };
  for (const Row& row : {Row{1, 62.7, 25.3}, Row{3, 1530.0, 16.9}}) {
    const LoopResult result = run_paper(paper_experiment(row.experiment, Oracle{}));
    INFO("experiment " << row.experiment << ": " << result.energy << ", " << result.squared_error);
    CHECK(relative_error(result.energy, row.energy) < kTolerance);
    CHECK(relative_error(result.squared_error, row.error) < kTolerance);
    CHECK(std::abs(result.steps.back().position[0] - kPi) < 1e-3);
    CHECK(std::abs(result.steps.back().velocity[0]) < 1e-3);
  }
}

TEST_CASE("Under the oracle the pendulum moves like the double integrator under the inner law", "[sim][paper]") {
  // z'' = (pi - z) - z' from (0, -2): underdamped, frequency sqrt(3)/2. Sample-and-hold differs by order Delta_u.
  const double w = std::sqrt(3.0) / 2.0;
  const auto exact = [&](double t) {
    const double a = -kPi, b = (-2.0 + 0.5 * a) / w;
    return kPi + std::exp(-0.5 * t) * (a * std::cos(w * t) + b * std::sin(w * t));
  };
  double before = 0.0;
  for (const double period : {0.02, 0.01, 0.005}) {
    LoopSetup setup = paper_experiment(1, Oracle{});
    setup.control_period = period;
    setup.duration = 5.0;
    double worst = 0.0;
    for (const LoopStep& step : run_paper(setup).steps)
      worst = std::max(worst, std::abs(step.position[0] - exact(step.time)));
    INFO("period " << period << ", " << worst);
    CHECK(worst < 10.0 * period);
    if (before > 0.0) CHECK(before / worst == Approx(2.0).epsilon(0.1));  // first order
    before = worst;
  }
}

TEST_CASE("The right-end sum of u^2 tends to the energy of a continuous controller", "[sim][paper]") {
  LoopSetup setup = paper_experiment(1, Proportional{100.0});
  setup.duration = 2.0;
  double before = 0.0;
  for (const double step : {1e-3, 5e-4, 2.5e-4}) {
    setup.quadrature_step = step;
    const LoopResult result = run_paper(setup);
    const double difference = std::abs(result.energy_riemann - result.energy);
    INFO("step " << step << ", difference " << difference);
    CHECK(difference > 0.0);
    if (before > 0.0) CHECK(before / difference == Approx(2.0).epsilon(0.1));  // first order
    before = difference;
  }
}
