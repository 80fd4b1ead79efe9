// Values that can be worked out by hand.

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "physics/plant.hpp"
#include "support/dense.hpp"

using namespace bayesctrl;

namespace {

constexpr double kRoundOff = 1e-14;

JointVector one(double x) { return JointVector::Constant(1, x); }

JointVector two(double x, double y) {
  JointVector v(2);
  v << x, y;
  return v;
}

}  // namespace

TEST_CASE("The pendulum is the paper's", "[physics]") {
  const Pendulum exp1{.length = 1.0, .friction = 1.0, .mass = 0.5};
  const Affine a = exp1.affine(one(0.3), one(-2.0));
  CHECK(a.drift[0] == Approx(-9.81 * std::sin(0.3) + 1.0 / 0.5 * 2.0).epsilon(kRoundOff));
  CHECK(a.gain(0, 0) == 2.0);
  // Upright at rest nothing accelerates, a little off it falls away.
  CHECK(std::abs(exp1.affine(one(std::numbers::pi), one(0.0)).drift[0]) < 1e-14);
  CHECK(exp1.affine(one(std::numbers::pi + 0.1), one(0.0)).drift[0] > 0.9);
  // Twice the length: half of gravity's term, a quarter of the others.
  const Pendulum longer{.length = 2.0, .friction = 1.0, .mass = 0.5};
  CHECK(longer.affine(one(0.3), one(-2.0)).drift[0] == Approx(-9.81 / 2.0 * std::sin(0.3) + 1.0).epsilon(kRoundOff));
  CHECK(longer.affine(one(0.3), one(-2.0)).gain(0, 0) == 0.5);
}

TEST_CASE("The pendulum's friction may depend on the angle", "[physics]") {
  const Pendulum p{.friction = 0.5, .mass = 2.0, .gravity = 0.0, .friction_amplitude = 0.3, .friction_centre = 1.0};
  CHECK(p.affine(one(1.0), one(1.0)).drift[0] == Approx(-0.8 / 2.0).epsilon(kRoundOff));
  CHECK(p.affine(one(1.0 + std::numbers::pi), one(1.0)).drift[0] == Approx(-0.2 / 2.0).epsilon(kRoundOff));
  CHECK(p.affine(one(1.0 + std::numbers::pi / 2), one(1.0)).drift[0] == Approx(-0.5 / 2.0).epsilon(kRoundOff));
  CHECK(p.problem().empty());
  CHECK(Pendulum{.friction = 0.2, .friction_amplitude = 0.3}.problem() ==
        "friction_amplitude exceeds friction: friction would turn negative");
}

TEST_CASE("The slide is Newton's law with viscous friction", "[physics]") {
  const Affine a = Mass{.mass = 4.0, .friction = 2.0}.affine(one(7.0), one(3.0));
  CHECK(a.drift[0] == -1.5);
  CHECK(a.gain(0, 0) == 0.25);
}

TEST_CASE("With hardly any second link the arm's first joint is a pendulum", "[physics]") {
  constexpr double kTiny = 1e-9;
  TwoLinkArm arm;
  arm.mass1 = 0.8;
  arm.com1 = 1.1;
  arm.inertia1 = arm.mass1 * arm.com1 * arm.com1;  // a point mass
  arm.friction1 = 0.6;
  arm.mass2 = kTiny;
  arm.com2 = 0.5;
  arm.inertia2 = kTiny / 3.0;
  const Pendulum pendulum{.length = 1.1, .friction = 0.6, .mass = 0.8};
  for (const double q : {-2.0, 0.3, 1.5}) {
    const Affine a = arm.affine(two(q, 0.7), two(1.3, -0.4));
    const Affine expected = pendulum.affine(one(q), one(1.3));
    CHECK(a.drift[0] == Approx(expected.drift[0]).margin(100.0 * kTiny));
    CHECK(a.gain(0, 0) == Approx(expected.gain(0, 0)).margin(100.0 * kTiny));
  }
}

TEST_CASE("A heavy rotor behind a high gear turns the arm's joints into two flywheels", "[physics]") {
  TwoLinkArm arm;
  arm.rotor_inertia = 10.0;
  arm.gear_ratio = 100.0;
  const Affine a = arm.affine(two(0.3, 0.4), two(0.0, 0.0));
  CHECK(a.gain(0, 0) == Approx(1e-5).epsilon(0.01));  // 1 / (n^2 J)
  CHECK(a.gain(1, 1) == Approx(1e-5).epsilon(0.01));
  CHECK(std::abs(a.gain(0, 1)) < 0.011 * a.gain(0, 0));  // coupling by -n J alone
}

TEST_CASE("The arm's gravity is that of its links in the position asked about", "[physics]") {
  TwoLinkArm arm;  // horizontal: all weights pull with their full lever
  const JointVector q = two(std::numbers::pi / 2, 0.0), v = two(0.0, 0.0);
  const Affine a = arm.affine(q, v);
  const JointVector torque = testing::dense::solve(a.gain, a.drift).col(0);
  CHECK(torque[0] == Approx(-9.81 * (0.5 + 1.0 + 0.5)).epsilon(1e-12));
  CHECK(torque[1] == Approx(-9.81 * 0.5).epsilon(1e-12));
}
