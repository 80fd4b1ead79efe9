#include "sim/loop.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <thread>

#include "physics/machine/free_run.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

LoopResult run(const LoopSetup& setup, std::uint64_t seed = 1) { return run_loop(setup, random_stream(seed, "loop")); }

/// Calls f(name, set-up) for every controller on every plant.
void for_each_setup(double duration, auto&& f) {
  for (const auto& [name, controller] : example_controllers()) {
    for_each_alternative(static_cast<Plant*>(nullptr),
                         [&, n = name, c = controller]<class PlantType>(const PlantType& plant) {
                           LoopSetup setup = example_setup(plant, c, duration);
                           setup.learner.period = 0.1;
                           setup.learner.drift_threshold = setup.learner.gain_threshold = 0.5;
                           f(n + " on " + std::string(PlantType::kName), setup);
                         });
  }
}

bool is_continuous(const Controller& controller) {
  return std::visit([](const auto& form) { return std::decay_t<decltype(form)>::kContinuous; }, controller);
}

}  // namespace

TEST_CASE("A run records every control call at its time, and the final state", "[sim]") {
  for_each_setup(0.5, [&](const std::string& name, const LoopSetup& setup) {
    const LoopResult result = run(setup);
    INFO(name << ": " << result.reason);
    REQUIRE(result.status == RunStatus::ok);
    REQUIRE(result.steps.size() == 51);
    for (std::size_t k = 0; k < 51; ++k) CHECK(result.steps[k].time == static_cast<double>(k) * 0.01);
    StateVector first(setup.initial_state.size());
    first << result.steps[0].position, result.steps[0].velocity;
    CHECK(first == setup.initial_state);
  });
}

TEST_CASE("The energy of a sample-and-hold run is the sum of u^2 dt", "[sim]") {
  constexpr double kRoundOff = 1e-12;
  for_each_setup(1.0, [&](const std::string& name, LoopSetup setup) {
    if (is_continuous(setup.controller)) return;
    setup.quadrature_step = 0.001;
    const LoopResult result = run(setup);
    double sum = 0.0;
    for (std::size_t k = 0; k + 1 < result.steps.size(); ++k) sum += result.steps[k].input.squaredNorm() * 0.01;
    INFO(name);
    CHECK(sum > 0.0);
    CHECK(result.energy == Approx(sum).epsilon(kRoundOff));
    CHECK(result.energy_riemann == Approx(sum).epsilon(kRoundOff));
  });
}

TEST_CASE("The recorded inputs, held from sample to sample, give the recorded motion", "[sim]") {
  constexpr double kTolerance = 1e-7;  // 1e-8 and 1e-10 per step
  for_each_setup(1.0, [&](const std::string& name, const LoopSetup& setup) {
    if (is_continuous(setup.controller)) return;
    const LoopResult result = run(setup);
    const auto samples = static_cast<Eigen::Index>(result.steps.size());
    const int n = joints(setup.plant);
    std::vector<double> time;
    Eigen::MatrixXd inputs(samples, n), position(samples, n);
    for (Eigen::Index k = 0; k < samples; ++k) {
      time.push_back(result.steps[k].time);
      inputs.row(k) = result.steps[k].input;
      position.row(k) = result.steps[k].position;
    }
    const Recording replayed = free_run({setup.plant}, setup.initial_state, time, inputs);
    INFO(name);
    CHECK(largest_difference(replayed.position, position) < kTolerance);
  });
}

TEST_CASE("The squared error is the integral of the distance to the reference in position and velocity", "[sim]") {
  for_each_setup(1.0, [&](const std::string& name, LoopSetup setup) {
    setup.reference = example_references(joints(setup.plant)).back().value;
    setup.control_period = 0.001;
    const LoopResult result = run(setup);
    double sum = 0.0;  // trapezia
    for (std::size_t k = 0; k < result.steps.size(); ++k) {
      const LoopStep& step = result.steps[k];
      const double weight = k == 0 || k + 1 == result.steps.size() ? 0.5e-3 : 1e-3;
      sum += weight * ((step.position - step.reference.position).squaredNorm() +
                       (step.velocity - step.reference.velocity).squaredNorm());
    }
    INFO(name);
    CHECK(result.squared_error == Approx(sum).epsilon(1e-4));
  });
}

TEST_CASE("On every plant the oracle follows every reference, the closer the shorter the control period", "[sim]") {
  for_each_alternative(static_cast<Plant*>(nullptr), [&]<class PlantType>(const PlantType& plant) {
    for (const auto& [name, reference] : example_references(example_joints<PlantType>)) {
      LoopSetup setup = example_setup(plant, Oracle{}, 4.0);
      setup.reference = reference;
      const ReferencePoint start = at(reference, 0.0);
      setup.initial_state << start.position, start.velocity;
      setup.control_period = 0.02;
      const double coarse = run(setup).squared_error;
      setup.control_period = 0.01;
      const double fine = run(setup).squared_error;
      INFO(PlantType::kName << " along " << name << ": " << coarse << ", " << fine);
      CHECK(fine < 0.1);
      if (coarse > 1e-12) CHECK(coarse / fine == Approx(4.0).epsilon(0.1));  // the square of a first-order error
    }
  });
}

TEST_CASE("A run follows from its set-up and stream alone, whatever ran before or beside it", "[sim]") {
  std::vector<LoopSetup> setups;
  for_each_setup(0.5, [&](const std::string&, LoopSetup setup) {
    setup.sensor.noise = 1e-3;
    setups.push_back(setup);
  });
  std::vector<LoopResult> forward, backward(setups.size()), beside(setups.size());
  for (const LoopSetup& setup : setups) forward.push_back(run(setup));
  for (std::size_t i = setups.size(); i-- > 0;) backward[i] = run(setups[i]);
  std::vector<std::thread> threads;
  for (std::size_t i = 0; i < setups.size(); ++i) threads.emplace_back([&, i] { beside[i] = run(setups[i]); });
  for (std::thread& thread : threads) thread.join();
  for (std::size_t i = 0; i < setups.size(); ++i) {
    CHECK(same_steps(forward[i], backward[i]));
    CHECK(same_steps(forward[i], beside[i]));
    CHECK(forward[i].energy == beside[i].energy);
    const bool sees_noise = !is_continuous(setups[i].controller);
    CHECK(same_steps(forward[i], run(setups[i], 2)) != sees_noise);
  }
}

TEST_CASE("No input exceeds its limit, probes included", "[sim]") {
  for_each_setup(1.0, [&](const std::string& name, LoopSetup setup) {
    setup.input_limit = {0.5};
    setup.learner.probing_input = {3.0};
    setup.learner.drift_threshold = 1e6;
    setup.learner.gain_threshold = 1e-9;
    double largest = 0.0;
    for (const LoopStep& step : run(setup).steps) largest = std::max(largest, step.input.cwiseAbs().maxCoeff());
    INFO(name);
    CHECK(largest == 0.5);
  });
}

TEST_CASE("A continuous controller acts on the state, and what is recorded is what it does", "[sim]") {
  LoopSetup setup = paper_experiment(1, Proportional{2.0});
  setup.duration = 1.0;
  setup.sensor = {.noise = 0.1, .velocity_noise = 0.1};
  for (const LoopStep& step : run(setup).steps) {
    const JointVector expected = 2.0 * setup.inner_law(step.reference, step.position, step.velocity);
    CHECK(step.input == expected);
  }
}

TEST_CASE("A duration holds so many whole control periods", "[sim]") {
  CHECK(control_steps(20.0, 0.01) == 2000);
  CHECK(control_steps(15.0, 0.01) == 1500);
  CHECK(control_steps(0.3, 0.1) == 3);  // 0.3 / 0.1 is below 3 in floating point
  CHECK(control_steps(1.0, 0.3) == 3);
  CHECK(control_steps(0.99, 1.0) == 0);
  for (int steps = 1; steps < 3000; ++steps) {
    for (const double period : {0.01, 0.001, 0.007, 1.0 / 3.0}) REQUIRE(control_steps(steps * period, period) == steps);
  }
}

TEST_CASE("A run of less than one period is its initial state", "[sim]") {
  for_each_setup(0.005, [&](const std::string& name, const LoopSetup& setup) {
    const LoopResult result = run(setup);
    INFO(name);
    CHECK(result.status == RunStatus::ok);
    CHECK(result.steps.size() == 1);
    CHECK(result.energy == 0.0);
  });
}
