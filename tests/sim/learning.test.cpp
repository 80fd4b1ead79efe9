// When the loop learns, what it learns, and what that is worth.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/loop.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

LoopResult run_learning(const LoopSetup& setup) { return run_loop(setup, random_stream(1, "learning")); }

/// Uncertain for ever: the drift if `drift`, else the gain.
LoopSetup always_probing(const Plant& plant, bool drift, long period, int hold) {
  LoopSetup setup = example_setup(plant, Adaptive{}, 1.0);
  setup.belief = Belief(example_prior(joints(plant)), joints(plant));
  setup.learner.period = 0.01 * static_cast<double>(period);
  setup.learner.hold_periods = hold;
  setup.learner.drift_threshold = drift ? 1e-300 : 1e6;
  setup.learner.gain_threshold = drift ? 1e6 : 1e-300;
  setup.learner.probing_input = {30.0};
  return setup;
}

struct Seen {
  long start, length;
  int mode;
};

/// Runs of equal modes that are not control.
std::vector<Seen> probes(const LoopResult& result) {
  std::vector<Seen> list;
  int before = Mode::kControl;
  for (std::size_t k = 0; k < result.steps.size(); ++k) {
    const int mode = result.steps[k].mode;
    if (mode != Mode::kControl && mode != before) list.push_back({static_cast<long>(k), 0, mode});
    if (mode != Mode::kControl) ++list.back().length;
    before = mode;
  }
  return list;
}

}  // namespace

TEST_CASE("Counted from the start, learning begins at multiples of the period", "[sim]") {
  for (const auto& [period, hold] : {std::pair{10L, 3}, {25L, 7}, {4L, 3}, {5L, 2}}) {
    const LoopResult result = run_learning(always_probing(Pendulum{}, true, period, hold));
    const std::vector<Seen> seen = probes(result);
    INFO("period " << period << ", hold " << hold);
    REQUIRE(static_cast<long>(seen.size()) == (100 + period - 1) / period);
    for (std::size_t i = 0; i < seen.size(); ++i) CHECK(seen[i].start == static_cast<long>(i) * period);
  }
}

TEST_CASE("An instant that falls into a probe is left out", "[sim]") {
  const std::vector<Seen> seen = probes(run_learning(always_probing(Pendulum{}, true, 2, 3)));
  REQUIRE(seen.size() == 25);
  for (std::size_t i = 0; i < seen.size(); ++i) CHECK(seen[i].start == static_cast<long>(4 * i));
}

TEST_CASE("Counted after the probe, learning begins a period after the end of the last one", "[sim]") {
  for (const auto& [period, hold] : {std::pair{10L, 3}, {25L, 7}, {1L, 3}, {2L, 5}}) {
    LoopSetup setup = always_probing(Pendulum{}, true, period, hold);
    setup.learner.schedule = Schedule::after_probe;
    const std::vector<Seen> seen = probes(run_learning(setup));
    INFO("period " << period << ", hold " << hold);
    REQUIRE(seen.size() >= 4);
    for (std::size_t i = 0; i < seen.size(); ++i) CHECK(seen[i].start == static_cast<long>(i) * (period + hold));
  }
}

TEST_CASE("A probe holds its input for hold_periods control periods", "[sim]") {
  for (const int hold : {2, 3, 5}) {
    for (const bool drift : {true, false}) {
      const LoopResult result = run_learning(always_probing(Pendulum{}, drift, 10, hold));
      const std::vector<Seen> seen = probes(result);
      REQUIRE(seen.size() == 10);
      for (const Seen& probe : seen) {
        CHECK(probe.length == hold);
        CHECK(probe.mode == (drift ? Mode::kLearnDrift : 0));
        for (long k = probe.start; k < probe.start + hold; ++k) CHECK(result.steps[k].input[0] == (drift ? 0.0 : 30.0));
      }
    }
  }
}

TEST_CASE("A sample of the drift lies at the middle of its probe, with the central difference for its value", "[sim]") {
  for_each_alternative(static_cast<Plant*>(nullptr), [&]<class PlantType>(const PlantType& plant) {
    for (const bool positions_only : {false, true}) {
      constexpr int n = example_joints<PlantType>;
      LoopSetup setup = always_probing(plant, true, 10, 3);
      setup.sensor.positions_only = positions_only;
      const LoopResult result = run_learning(setup);
      const std::vector<Seen> seen = probes(result);
      REQUIRE(result.belief.drift_points() == static_cast<int>(seen.size()));
      for (std::size_t p = 0; p < seen.size(); ++p) {
        const LoopStep &first = result.steps[seen[p].start], &middle = result.steps[seen[p].start + 1],
                       &last = result.steps[seen[p].start + 2];
        JointVector velocity = middle.velocity, value = (last.velocity - first.velocity) / 0.02;
        if (positions_only) {
          velocity = (last.position - first.position) / 0.02;
          value = (last.position - 2.0 * middle.position + first.position) / (0.01 * 0.01);
        }
        INFO(PlantType::kName << ", probe " << p);
        for (int i = 0; i < n; ++i) {
          CHECK(result.belief.drift(i).targets()[p] == value[i]);
          const Eigen::VectorXd x = result.belief.drift(i).inputs().points().row(static_cast<Eigen::Index>(p));
          CHECK(x.head(n) == middle.position);
          CHECK(x.tail(n) == velocity);
        }
      }
    }
  });
}

TEST_CASE("What a probe teaches is the true drift and gain up to the error of the difference", "[sim]") {
  constexpr double kDifference = 0.02;  // dt^2 / 6 of the third derivative of the velocity, and the hold's jump in it
  for_each_alternative(static_cast<Plant*>(nullptr), [&]<class PlantType>(const PlantType& plant) {
    const LoopResult drift = run_learning(always_probing(plant, true, 10, 3));
    const LoopResult gain = run_learning(always_probing(plant, false, 10, 3));
    INFO(PlantType::kName);
    const auto truth_at = [&](const Posterior& data, Eigen::Index p) {
      const Eigen::VectorXd x = data.inputs().points().row(p);
      return plant.affine(x.head(example_joints<PlantType>), x.tail(example_joints<PlantType>));
    };
    for (Eigen::Index p = 0; p < drift.belief.drift_points(); ++p) {
      const Posterior& data = drift.belief.drift(0);
      CHECK(data.targets()[p] == Approx(truth_at(data, p).drift[0]).margin(kDifference).epsilon(kDifference));
    }
    // The belief over a is empty here: its mean of 0 is part of the estimate (q'' - E a) / u.
    REQUIRE(gain.belief.gain_points() > 0);
    for (Eigen::Index p = 0; p < gain.belief.gain(0, 0).size(); ++p) {
      const Posterior& data = gain.belief.gain(0, 0);
      const Affine truth = truth_at(data, p);
      CHECK(std::exp(data.targets()[p]) ==
            Approx(truth.gain(0, 0) + truth.drift[0] / 30.0).margin(kDifference).epsilon(kDifference));
    }
  });
}

TEST_CASE("A probe that the limit cuts is learned from with the input that was applied", "[sim]") {
  LoopSetup setup = always_probing(Mass{.mass = 2.0}, false, 10, 3);
  setup.input_limit = {3.0};
  const LoopResult result = run_learning(setup);
  REQUIRE(result.belief.gain_points() > 5);
  for (const double log_gain : result.belief.gain(0, 0).targets())
    CHECK(std::exp(log_gain) == Approx(0.5).epsilon(1e-6));
}

TEST_CASE("Estimates of the gain that are not positive are refused and counted", "[sim]") {
  LoopSetup setup = always_probing(Mass{}, false, 10, 3);
  BeliefPrior prior = example_prior(1);
  prior.drift[0].mean = 100.0;  // believed to push harder than the probe does
  setup.belief = Belief(prior, 1);
  const LoopResult result = run_learning(setup);
  CHECK(result.learning.refused_gain_estimates == 10);
  CHECK(result.belief.gain_points() == 0);
  CHECK(result.status == RunStatus::ok);
}

TEST_CASE("A slide with friction is learned to within the thresholds, reaches its goal, and is relearned with less",
          "[sim]") {
  const Mass truth{.mass = 2.0, .friction = 1.6};
  LoopSetup setup = example_setup(truth, Adaptive{}, 20.0);
  BeliefPrior prior = example_prior(1);
  prior.drift = {process_with({SquaredExponential{2.0, {20.0, 6.0}}}, 1e-6)};
  prior.input_gain = {LogNormalProcess{process_with({SquaredExponential{1.0, {20.0, 20.0}}}, 1e-4)}};
  setup.belief = Belief(prior, 1);
  setup.learner.period = 0.1;
  setup.learner.probing_input = {5.0};  // what is unknown of a, sd up to 0.03, then counts for little in b
  setup.inner_law = {1.0, 2.0};
  const LoopResult result = run_learning(setup);
  REQUIRE(result.status == RunStatus::ok);
  CHECK(result.belief.drift_points() > 0);
  CHECK(result.belief.gain_points() > 0);
  double drift_error = 0.0, log_gain_error = 0.0;
  for (const LoopStep& step : result.steps) {
    StateVector x(2);
    x << step.position, step.velocity;
    const BeliefMarginals m = result.belief.predict(x);
    drift_error += std::pow(m.drift_mean[0] + 0.8 * step.velocity[0], 2);
    log_gain_error += std::pow(m.log_gain_mean[0] - std::log(0.5), 2);
  }
  const auto samples = static_cast<double>(result.steps.size());
  CHECK(drift_error / samples < setup.learner.drift_threshold);
  CHECK(log_gain_error / samples < setup.learner.gain_threshold);
  CHECK(std::abs(result.steps.back().position[0] - 0.5) < 1e-2);

  setup.belief = result.belief;
  const LoopResult second = run_learning(setup);
  const int fresh = result.belief.drift_points() + result.belief.gain_points();
  CHECK(second.belief.drift_points() + second.belief.gain_points() - fresh < fresh);
  CHECK(probes(second).size() < probes(result).size());
}

TEST_CASE("Hyper-parameters are tuned when it is said, and tuning at the end does not touch the run", "[sim]") {
  LoopSetup setup = always_probing(Pendulum{}, true, 10, 3);
  const LoopResult never = run_learning(setup);
  CHECK(never.learning.tuning_evaluations == 0);
  setup.tuning.when = TuneWhen::at_end;
  const LoopResult at_end = run_learning(setup);
  CHECK(at_end.learning.tuning_evaluations > 0);
  CHECK(same_steps(never, at_end));
  CHECK(at_end.belief.drift(0).targets() == never.belief.drift(0).targets());
  CHECK(at_end.belief.drift(0).log_marginal_likelihood() > never.belief.drift(0).log_marginal_likelihood());
  setup.tuning.when = TuneWhen::every_sample;
  setup.tuning.every = 1000;  // never reached
  CHECK(run_learning(setup).learning.tuning_evaluations == 0);
  setup.tuning.every = 10;  // reached once, by the last sample
  const LoopResult once = run_learning(setup);
  CHECK(once.learning.tuning_evaluations > 0);
  setup.tuning.every = 1;
  const LoopResult each = run_learning(setup);
  CHECK(each.learning.tuning_evaluations > once.learning.tuning_evaluations);
  CHECK_FALSE(same_steps(each, never));
}
