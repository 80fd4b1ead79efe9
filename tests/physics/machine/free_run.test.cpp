#include "physics/machine/free_run.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "physics/catalogue.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kTolerance = 1e-9;  // 1e-8 and 1e-10 per step, and polynomials of low degree are integrated exactly

const std::vector<double> kTime{0.0, 0.1, 0.3, 1.0};  // unequal periods

Eigen::MatrixXd column(std::initializer_list<double> values) {
  Eigen::MatrixXd m(static_cast<Eigen::Index>(values.size()), 1);
  std::copy(values.begin(), values.end(), m.data());
  return m;
}

}  // namespace

TEST_CASE("A slide moves by Newton's law under forces that are held from sample to sample", "[physics]") {
  const Recording run =
      free_run({Mass{.mass = 2.0}}, Eigen::Vector2d(1.0, -1.0), kTime, column({4.0, -6.0, 0.0, 99.0}));
  // v: -1, -1 + 2 * 0.1, -0.8 - 3 * 0.2, then constant; q by the mean velocity of each period.
  CHECK(run.time == kTime);
  CHECK(run.velocity.isApprox(column({-1.0, -0.8, -1.4, -1.4}), kTolerance));
  CHECK(run.position.isApprox(column({1.0, 0.91, 0.69, -0.29}), kTolerance));
  CHECK(run.input == column({4.0, -6.0, 0.0, 99.0}));
  CHECK(run.samples() == 4);
}

TEST_CASE("Where and in how many samples a motion is recorded does not change it", "[physics]") {
  for_each_plant(1, [&]<class PlantType>(const PlantType& plant) {
    constexpr int n = example_joints<PlantType>;
    const StateVector start = StateVector::Constant(2 * n, 0.7);
    std::vector<double> fine;
    for (int k = 0; k <= 200; ++k) fine.push_back(0.01 * k);
    const Recording dense = free_run({plant}, start, fine, Eigen::MatrixXd::Constant(201, n, 0.5));
    const Recording ends = free_run({plant}, start, {0.0, 2.0}, Eigen::MatrixXd::Constant(2, n, 0.5));
    INFO(PlantType::kName);
    CHECK((dense.position.row(200) - ends.position.row(1)).norm() < 1e-6);
    CHECK((dense.velocity.row(200) - ends.velocity.row(1)).norm() < 1e-6);
  });
}

TEST_CASE("A free run has the model's effects", "[physics]") {
  const std::vector<double> time{0.0, 0.5, 1.0};
  const Eigen::Vector2d start(1.0, 0.0);
  // Friction of 3 N holds 2 N, and takes its part of 5 N.
  const Model rough{Mass{.mass = 2.0}, {{CoulombFriction{3.0}, 0}}};
  CHECK(free_run(rough, start, time, column({2.0, 2.0, 2.0})).position.isApprox(column({1.0, 1.0, 1.0}), kTolerance));
  CHECK(free_run(rough, start, time, column({5.0, 5.0, 5.0})).velocity.isApprox(column({0.0, 0.5, 1.0}), 1e-6));
  const Model shifted{Mass{.mass = 2.0}, {{SensorOffset{0.25}, 0}}};
  CHECK(free_run(shifted, start, time, column({0.0, 0.0, 0.0})).position.isApprox(column({1.25, 1.25, 1.25})));
  for_each_plant(1, [&]<class PlantType>(const PlantType& plant) {
    constexpr int n = example_joints<PlantType>;
    const StateVector begin = StateVector::Constant(2 * n, 0.7);
    const Eigen::MatrixXd inputs = Eigen::MatrixXd::Constant(3, n, 0.5);
    const Model with_nothing{plant, {{ConstantBias{0.0}, 0}}};
    INFO(PlantType::kName);
    CHECK((free_run(with_nothing, begin, time, inputs).position - free_run({plant}, begin, time, inputs).position)
              .norm() < 1e-6);
  });
}

TEST_CASE("A free run that fits not its plant is the caller's error, one that diverges a numerical one", "[physics]") {
  const Model model{Mass{}};
  CHECK_THROWS_AS(free_run(model, Eigen::Vector4d::Zero(), kTime, column({0, 0, 0, 0})), std::invalid_argument);
  CHECK_THROWS_AS(free_run(model, Eigen::Vector2d::Zero(), kTime, column({0, 0, 0})), std::invalid_argument);
  CHECK_THROWS_AS(free_run(model, Eigen::Vector2d::Zero(), kTime, Eigen::MatrixXd::Zero(4, 2)), std::invalid_argument);
  CHECK_THROWS_AS(free_run(model, Eigen::Vector2d::Zero(), kTime, column({0, INFINITY, 0, 0})), NumericalError);
  CHECK_THROWS_AS(free_run(model, Eigen::Vector2d(NAN, 0.0), kTime, column({0, 0, 0, 0})), NumericalError);
  CHECK(free_run(model, Eigen::Vector2d::Zero(), {}, Eigen::MatrixXd(0, 1)).samples() == 0);
}
