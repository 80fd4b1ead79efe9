#include "control/reference.hpp"

#include <catch2/catch.hpp>

#include "support/compare.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

TEST_CASE("Velocity and acceleration of every reference are the derivatives of its position", "[control]") {
  constexpr double kDifference = 1e-9;  // step 1e-2, extrapolated, of sines with frequencies up to 2
  for (int joints = 1; joints <= kMaxJoints; ++joints) {
    for (const auto& [name, reference] : example_references(joints)) {
      REQUIRE(bayesctrl::joints(reference) == joints);
      for (const double t : {0.0, 0.3, 2.7, 11.0}) {
        const ReferencePoint point = at(reference, t);
        REQUIRE(point.position.size() == joints);
        for (int i = 0; i < joints; ++i) {
          INFO(name << ", joint " << i << ", t = " << t);
          const auto position = [&](double s) { return at(reference, s).position[i]; };
          const auto velocity = [&](double s) { return at(reference, s).velocity[i]; };
          CHECK(point.velocity[i] == Approx(derivative(position, t, 1e-2)).margin(kDifference));
          CHECK(point.acceleration[i] == Approx(derivative(velocity, t, 1e-2)).margin(kDifference));
        }
      }
    }
  }
}

TEST_CASE("A set-point stays where it is", "[control]") {
  const Setpoint setpoint{{1.0, -2.0}};
  for (const double t : {0.0, 5.0}) {
    CHECK(setpoint.at(t).position == Eigen::Vector2d(1.0, -2.0));
    CHECK(setpoint.at(t).velocity == Eigen::Vector2d::Zero());
    CHECK(setpoint.at(t).acceleration == Eigen::Vector2d::Zero());
  }
}

TEST_CASE("A sine has its centre, amplitude and frequency in each joint", "[control]") {
  const Sine sine{{1.0, 0.0}, {0.5, 2.0}, {2.0, 3.0}};
  CHECK(sine.at(0.0).position == Eigen::Vector2d(1.0, 0.0));
  CHECK(sine.at(0.0).velocity == Eigen::Vector2d(1.0, 6.0));
  CHECK(sine.at(std::acos(0.0) / 2.0).position[0] == Approx(1.5).epsilon(1e-14));
  CHECK(sine.problem().empty());
  CHECK(Sine{{0.0}, {1.0, 1.0}, {1.0}}.problem() == "sine needs as many amplitudes and frequencies as centres");
  CHECK_FALSE(Sine{{0.0}, {1.0}, {}}.problem().empty());
}
