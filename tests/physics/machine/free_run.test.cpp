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

TEST_CASE("A slide bounces off a stop as a spring of any stiffness throws it back", "[physics]") {
  const double side = GENERATE(1.0, -1.0), stiffness = GENERATE(10.0, 1e3, 1e5, 1e7);
  const HardStop stop{.position = 0.2 * side, .stiffness = stiffness, .damping = 1e-9};
  const Recording run =
      free_run({Mass{}, {{stop, 0}}}, Eigen::Vector2d(0.0, side), {0.0, 1.37, 3.0}, Eigen::MatrixXd::Zero(3, 1));
  INFO("stiffness " << stiffness);  // it meets the stop after 0.2 s and leaves it half a swing later
  const double contact = 3.141592653589793 / std::sqrt(stiffness);
  CHECK(run.position(2, 0) * side == Approx(0.2 - (3.0 - 0.2 - contact)).margin(1e-4));
  CHECK(run.velocity(2, 0) * side == Approx(-1.0).margin(1e-4));
}

TEST_CASE("A stop pushes and never pulls, however it is damped", "[physics]") {
  const double damping = GENERATE(0.1, 3.0, 20.0, 200.0);
  std::vector<double> time;
  for (int k = 0; k <= 3000; ++k) time.push_back(1e-3 * k);
  const Model slide{Mass{}, {{HardStop{.position = 0.2, .stiffness = 100.0, .damping = damping}, 0}}};
  const Recording run = free_run(slide, Eigen::Vector2d(0.0, 1.0), time, Eigen::MatrixXd::Zero(3001, 1));
  for (Eigen::Index k = 1; k < run.samples(); ++k) CHECK(run.velocity(k, 0) <= run.velocity(k - 1, 0) + 1e-12);
  CHECK(run.velocity(3000, 0) < 0.0);
  CHECK(run.velocity(3000, 0) > -1.0);
}

TEST_CASE("A run ends wherever its stops are and however they are met", "[physics]") {
  for (const double place : {1e-12, 0.5, 40.0, 3e5}) {
    for (const double speed : {1e-9, 1.0, 1e4}) {
      // Pushed on by turns, between two stops of which one touches the other.
      const Model slide{Mass{}, {{HardStop{place, 1e4, 5.0}, 0}, {HardStop{place + 1e-14, 1e3, 50.0}, 0}}};
      std::vector<double> time;
      Eigen::MatrixXd input(200, 1);
      for (int k = 0; k < 200; ++k) {
        time.push_back(0.01 * k);
        input(k, 0) = k / 20 % 2 == 0 ? 50.0 : -50.0;
      }
      const Recording run = free_run(slide, Eigen::Vector2d(place - 1e-3, speed), time, input);
      INFO("stops at " << place << ", met at " << speed);
      CHECK(run.position.allFinite());
    }
  }
}

TEST_CASE("A stop that no step can follow is refused", "[physics]") {
  const Model slide{Mass{}, {{HardStop{.position = 0.2, .stiffness = 1e12, .damping = 1.0}, 0}}};
  const auto run = [&](double v) {
    return free_run(slide, Eigen::Vector2d(0.0, v), {0.0, 1.0}, Eigen::MatrixXd::Zero(2, 1));
  };
  CHECK_THROWS_WITH(run(1.0), Catch::Contains("hard_stop in joint 1 is stiffer than can be followed"));
  CHECK(run(-1.0).position(1, 0) == Approx(-1.0));  // it is never met
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
