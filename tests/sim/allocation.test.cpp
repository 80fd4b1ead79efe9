// The control step allocates nothing.

#include <array>
#include <catch2/catch.hpp>
#include <memory>
#include <optional>

#include "sim/loop.hpp"
#include "support/allocations.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"
#include "support/paper.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

/// Allocations of a run that does not learn, of so many steps.
long allocations_of_run(LoopSetup setup, int steps) {
  setup.duration = steps * setup.control_period;
  std::optional<LoopResult> result;
  const long count = allocations_of([&] { result = run_loop(setup, random_stream(1, "allocation")); });
  REQUIRE(result->status == RunStatus::ok);
  REQUIRE(static_cast<int>(result->steps.size()) == steps + 1);
  return count;
}

}  // namespace

TEST_CASE("The count sees allocations of every kind, and only while it lives", "[allocation]") {
  std::unique_ptr<int> single;  // kept, so that the compiler may not leave the allocations out
  std::vector<double> list;
  Eigen::VectorXd vector;
  CHECK(allocations_of([&] { single = std::make_unique<int>(1); }) == 1);
  CHECK(allocations_of([&] { list.resize(100); }) == 1);
  CHECK(allocations_of([&] { vector = Eigen::VectorXd::Ones(100); }) == 1);  // by malloc, aligned
  CHECK(allocations_of([&] { list.clear(); }) == 0);
  const AllocationCount count;
  single = std::make_unique<int>(2);
  single = std::make_unique<int>(3);
  CHECK(count.value() == 2);
}

TEST_CASE("Prediction allocates nothing, with every kernel", "[allocation]") {
  const Eigen::MatrixXd inputs = random_points(150, 2, 3.0, 91);
  for (const auto& [name, kernel] : example_kernels(2)) {
    GaussianProcess prior = process_with(kernel, 1e-2);
    prior.mean_function = [](std::span<const double> x) { return x[0]; };
    const Posterior posterior = condition(prior, inputs, smooth_at(inputs));
    const Eigen::Vector2d x(0.1, 0.2);
    double sum = 0.0;
    INFO(name);
    CHECK(allocations_of([&] { sum += posterior.predict(span_of(x)).mean; }) == 0);
    CHECK(std::isfinite(sum));
  }
}

TEST_CASE("Over budget, samples and predictions allocate nothing, with every kernel", "[allocation]") {
  const Eigen::MatrixXd inputs = random_points(200, 2, 3.0, 93);
  const std::vector<double> targets = smooth_at(inputs);
  for (const auto& [name, kernel] : example_kernels(2)) {
    INFO(name);
    GaussianProcess prior = process_with(kernel, 1e-2);
    prior.budget = 40;
    Posterior posterior = condition(prior, inputs.topRows(100), {targets.data(), 100});
    REQUIRE(posterior.over_budget());
    double sum = 0.0;
    const long count = allocations_of([&] {
      for (Eigen::Index i = 100; i < 200; ++i) {
        const std::array x{inputs(i, 0), inputs(i, 1)};
        sum += posterior.predict(x).mean;
        posterior.extend(x, targets[static_cast<std::size_t>(i)]);
      }
    });
    CHECK(count == 0);
    CHECK(std::isfinite(sum));
  }
}

TEST_CASE("Absorbing samples that there is room for allocates nothing, with every kernel", "[allocation]") {
  const Eigen::MatrixXd inputs = random_points(150, 2, 3.0, 92);
  for (const auto& [name, kernel] : example_kernels(2)) {
    Posterior posterior(process_with(kernel, 1e-2), 2);
    posterior.reserve(150);
    INFO(name);
    CHECK(allocations_of([&] {
            for (Eigen::Index i = 0; i < 150; ++i) {
              const Eigen::Vector2d x = inputs.row(i);
              posterior.extend(span_of(x), 1.0);
            }
          }) == 0);
    CHECK(posterior.size() == 150);
  }
}

TEST_CASE("Asking a belief and inverting it allocates nothing, for any number of joints", "[allocation]") {
  for (int n = 1; n <= kMaxJoints; ++n) {
    const Belief belief = example_belief(n, 20);
    const StateVector x = StateVector::Constant(2 * n, 0.3);
    const JointVector acceleration = JointVector::Ones(n);
    JointVector u;
    INFO(n << " joints");
    CHECK(allocations_of([&] {
            const BeliefMarginals marginals = belief.predict(x);
            u = feedback_linearise(marginals.drift_mean, marginals.gain_mean, acceleration);
          }) == 0);
    CHECK(u.allFinite());
    Belief together = belief;
    together.join();
    together.predict(x);  // buffers of the thread
    CHECK(allocations_of([&] { u = linearise_cautiously(together.predict(x), acceleration, 0.1); }) == 0);
    CHECK(u.allFinite());
  }
}

TEST_CASE("With every controller, plant and reference the control step allocates nothing", "[allocation]") {
  for (const auto& [name, controller] : example_controllers()) {
    for_each_alternative(
        static_cast<Plant*>(nullptr), [&, n = name, c = controller]<class PlantType>(const PlantType& plant) {
          LoopSetup setup = example_setup(plant, c, 1.0);
          setup.learner = never_learning();
          setup.input_limit = {20.0};
          for (const auto& [reference_name, reference] : example_references(example_joints<PlantType>)) {
            setup.reference = reference;
            allocations_of_run(setup, 10);  // buffers of the thread
            const long short_run = allocations_of_run(setup, 1000), long_run = allocations_of_run(setup, 2000);
            INFO(n << " on " << PlantType::kName << " along " << reference_name);
            CHECK(short_run == long_run);
            CHECK(short_run < 200);
          }
        });
  }
}

TEST_CASE("With every flaw of the sensor the control step allocates nothing", "[allocation]") {
  LoopSetup setup = example_setup(TwoLinkArm{}, Adaptive{}, 1.0);
  setup.learner = never_learning();
  setup.sensor = {.positions_only = true, .noise = 1e-6, .velocity_noise = 1e-6, .quantum = 1e-6, .delay_periods = 2};
  allocations_of_run(setup, 10);
  CHECK(allocations_of_run(setup, 300) == allocations_of_run(setup, 600));
}
