// A torque that remembers, in the machine and beside it.

#include "physics/remainder.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "physics/machine.hpp"

using namespace bayesctrl;

TEST_CASE("A remainder that remembers moves a slide as its differential equation says", "[remainder]") {
  // m' = (v - m)/tau, q'' = u + w (m - v), u held: integrated finely by hand.
  constexpr double kTau = 0.3, kWeight = 2.0, kInput = 0.7;
  Remainder remainder;
  remainder.terms.push_back({TermKind::late_velocity, 0, -1, kTau, 1.0, 0.0, 1.0, kWeight});
  const Machine machine(Mass{.mass = 1.0, .friction = 0.0}, {}, remainder);
  std::vector<double> time;
  for (int k = 0; k <= 400; ++k) time.push_back(0.005 * k);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Constant(401, 1, kInput);
  StateVector start(2);
  start << 0.0, 0.0;
  const Eigen::MatrixXd q = machine.run(start, time, machine.drives(time, input), 0, 400, 1e-3);
  double x = 0.0, v = 0.0, m = 0.0;
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 200000; ++i) {
    const double a = kInput + kWeight * (m - v);
    x += kStep * (v + 0.5 * kStep * a);
    m += kStep * (v - m) / kTau;
    v += kStep * a;
  }
  CHECK(q(400, 0) == Approx(x).epsilon(3e-3));
}

TEST_CASE("Beyond what it has seen a remainder goes on constant in velocity and input and fades in position",
          "[remainder]") {
  Remainder remainder;
  remainder.terms.push_back({TermKind::sign_velocity, 0, -1, 0.5, 1.0, 0.0, 1.0, 3.0});
  remainder.regions.push_back({-1.0, 1.0, 2.0, 1.0, 10.0});
  const auto torque = [&](double q, double v, double u) {
    const JointVector at = JointVector::Constant(1, q), speed = JointVector::Constant(1, v),
                      input = JointVector::Constant(1, u);
    return remainder.torque(remainder.begin(at, speed, input), at, speed, input, 0.0)[0];
  };
  CHECK(torque(0.0, 5.0, 0.0) == torque(0.0, 2.0, 0.0));
  CHECK(torque(0.0, 1.0, 9.0) == torque(0.0, 1.0, 0.0));
  CHECK(std::abs(torque(3.0, 2.0, 0.0)) < 1e-6);
}

TEST_CASE("Joints whose friction and remainder set one another free without end rest until the next sample",
          "[remainder]") {
  // Torques against friction that jump where a joint stops; a step of the integration must come to an end.
  const TwoLinkArm arm{};
  for (int draw = 0; draw < 20; ++draw) {
    RandomStream random(static_cast<std::uint64_t>(draw));
    Remainder remainder;
    for (const int joint : {0, 1}) {
      for (const double width : {1e-7, 1e-4}) {
        remainder.terms.push_back(
            {TermKind::sign_velocity, joint, -1, width, 1.0, 0.0, 1.0, draw_uniform(random, -3.0, 3.0)});
      }
    }
    const Machine machine(arm, {{CoulombFriction{1.0}, 0, -1}, {CoulombFriction{1.0}, 1, -1}}, remainder);
    std::vector<double> time;
    Eigen::MatrixXd input(101, 2);
    for (int k = 0; k <= 100; ++k) {
      time.push_back(0.005 * k);
      input.row(k) << 2.0 * std::sin(20.0 * time.back()), 1.5 * std::cos(31.0 * time.back());
    }
    StateVector start(4);
    start << 0.1, -0.1, 0.01, -0.02;
    CHECK(machine.run(start, time, machine.drives(time, input), 0, 100, 0.005).allFinite());
  }
}
