// Hidden states of effects: each effect has its own, whatever else acts in the same joint.

#include <catch2/catch.hpp>
#include <cmath>

#include "physics/catalogue.hpp"
#include "physics/machine/machine.hpp"
#include "support/runge_kutta.hpp"

using namespace bayesctrl;

namespace {

/// A slide of mass 2 with two elements of Dahl's law, by plain Runge-Kutta steps of 10 us: positions every 10 ms.
std::vector<double> two_elements(const PreslidingHysteresis& a, const PreslidingHysteresis& b,
                                 const std::vector<double>& time, const std::vector<double>& force) {
  constexpr int kParts = 1000;
  using State = std::array<double, 4>;  // q, v, z of a, z of b
  State x{0.0, 0.0, 0.0, 0.0};
  std::vector<double> q{0.0};
  for (std::size_t k = 0; k + 1 < time.size(); ++k) {
    const double h = (time[k + 1] - time[k]) / kParts;
    const auto rate = [&](const State& s, double /*t*/) {
      const double speed = std::abs(s[1]);
      return State{s[1], (force[k] - a.stiffness * s[2] - b.stiffness * s[3]) / 2.0,
                   s[1] - speed * s[2] * a.stiffness / a.level, s[1] - speed * s[3] * b.stiffness / b.level};
    };
    for (int i = 0; i < kParts; ++i) x = testing::runge_kutta_step(x, h, rate);
    q.push_back(x[0]);
  }
  return q;
}

}  // namespace

TEST_CASE("Two elements with hidden states in one joint move it as a fine integration of both", "[effects][physics]") {
  const PreslidingHysteresis soft{60.0, 1.5}, stiff{400.0, 0.8};
  std::vector<double> time, force;
  for (int k = 0; k <= 300; ++k) {
    time.push_back(0.01 * k);
    force.push_back(4.0 * std::sin(2.5 * time.back()) + 1.5 * std::sin(7.0 * time.back()));
  }
  const std::vector<double> reference = two_elements(soft, stiff, time, force);
  const Machine machine(Mass{2.0, 0.0}, {{soft}, {LinearSpring{1e-12}}, {stiff}});
  CHECK(machine.hidden_count() == 2);
  const Eigen::MatrixXd input = Eigen::Map<const Eigen::VectorXd>(force.data(), 301);
  const Eigen::MatrixXd q =
      machine.run(StateVector::Zero(2), time, machine.drives(time, input), 0, time.size() - 1, 1e-3);
  double largest = 0.0, range = 0.0;
  for (std::size_t k = 0; k < time.size(); ++k) {
    largest = std::max(largest, std::abs(q(static_cast<Eigen::Index>(k), 0) - reference[k]));
    range = std::max(range, std::abs(reference[k]));
  }
  CAPTURE(largest, range);
  CHECK(range > 0.05);
  CHECK(largest < 2e-5 * range);

  // Along the same motion the states are those that move the machine: a run from the middle goes on as the whole.
  Eigen::MatrixXd states;
  const std::vector<Drive> drives = machine.drives(time, input);
  machine.run(StateVector::Zero(2), time, drives, 0, 300, 1e-3, {{}, JointVector::Zero(1)}, &states);
  const auto after = [&](const HiddenStates& begin, std::size_t from, std::size_t to) {
    return machine.hidden_after(begin, time, states.leftCols(1), states.rightCols(1), drives, from, to);
  };
  const HiddenStates middle = after(machine.hidden_at_rest(), 0, 150);
  REQUIRE(middle.effects.size() == 2);
  CHECK(after(after(machine.hidden_at_rest(), 0, 61), 61, 150).effects == middle.effects);
  const Eigen::MatrixXd rest = machine.run(states.row(150), time, drives, 150, 300, 1e-3, middle);
  CHECK((rest - q.bottomRows(151)).cwiseAbs().maxCoeff() < 1e-3 * range);
}

TEST_CASE("More hidden states than a machine may have, or other ones than it has, are refused", "[effects][physics]") {
  const std::vector<Effect> many(kMaxHidden + 1, Effect{PreslidingHysteresis{}});
  CHECK_THROWS_AS(Machine(Mass{}, many), std::invalid_argument);
  const Machine machine(Mass{}, {{PreslidingHysteresis{}}});
  const std::vector<double> time{0.0, 0.1};
  const std::vector<Drive> drives = machine.drives(time, Eigen::MatrixXd::Zero(2, 1));
  CHECK_THROWS_AS(
      machine.run(StateVector::Zero(2), time, drives, 0, 1, 1e-3, {HiddenVector::Zero(2), JointVector::Zero(1)}),
      std::invalid_argument);
}

TEST_CASE("Friction that gives is never stronger than its level, whatever its state was put to", "[effects][physics]") {
  for (const double z : {-400.0, -0.1, -0.01, 0.0, 0.01, 0.1, 400.0}) {
    INFO("z = " << z);
    const PreslidingHysteresis law{50.0, 1.5};
    const double torque = law.torque_of({z}, JointState{});
    CHECK(std::abs(torque) <= law.level);
    if (std::abs(z) * law.stiffness < law.level) CHECK(torque == Approx(-law.stiffness * z));
  }
}

TEST_CASE(
    "A slide and the load that it takes along by a spring move as the closed form of two masses says, also where "
    "the load is the heavier",
    "[effects][physics]") {
  const double mass = 0.35, inertia = GENERATE(0.2, 7.0), stiffness = GENERATE(30.0, 4000.0), force = 2.0;
  const double both = 1.0 / inertia + 1.0 / mass, damping = 0.6 * std::sqrt(stiffness / both);
  const Machine machine(Mass{mass, 0.0}, {{ElasticLoad{stiffness, damping, inertia}}});
  std::vector<double> time;
  for (int k = 0; k <= 200; ++k) time.push_back(0.01 * k);
  const std::vector<Drive> drives = machine.drives(time, Eigen::MatrixXd::Constant(201, 1, force));
  const Eigen::MatrixXd q = machine.run(StateVector::Zero(2), time, drives, 0, 200, 0.01, machine.hidden_at_rest());
  // x = l - q: x'' = -(stiffness x + damping x') both - force / mass, and mass q + inertia l = force t^2 / 2.
  const double fades = 0.5 * damping * both, swings = std::sqrt(stiffness * both - fades * fades);
  const double rests = -force / (mass * stiffness * both);
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    const double x =
        rests * (1.0 - std::exp(-fades * t) * (std::cos(swings * t) + fades / swings * std::sin(swings * t)));
    CAPTURE(inertia, stiffness, t);
    CHECK(std::abs(q(static_cast<Eigen::Index>(k), 0) - (0.5 * force * t * t - inertia * x) / (inertia + mass)) <
          1e-2 * std::abs(rests));
  }
}

TEST_CASE("A motor that pushes through a spring and the slide behind it move as the closed form of two masses says",
          "[effects][physics]") {
  const double mass = 0.7, inertia = GENERATE(0.2, 1.5), stiffness = GENERATE(30.0, 400.0), force = 2.0;
  const double damping = 0.3 * std::sqrt(stiffness * inertia);
  const Machine machine(Mass{mass, 0.0}, {{JointElasticity{stiffness, damping, inertia}}});
  std::vector<double> time;
  for (int k = 0; k <= 200; ++k) time.push_back(0.01 * k);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Constant(201, 1, force);
  const std::vector<Drive> drives = machine.drives(time, input);
  Eigen::MatrixXd states;
  const Eigen::MatrixXd q =
      machine.run(StateVector::Zero(2), time, drives, 0, 200, 1e-3, machine.hidden_at_rest(), &states);
  // x = m - q: x'' = force / inertia - (stiffness x + damping x') both, and inertia m + mass q = force t^2 / 2.
  const double both = 1.0 / inertia + 1.0 / mass, fades = 0.5 * damping * both;
  const double swings = std::sqrt(stiffness * both - fades * fades), rests = force / (inertia * stiffness * both);
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    const double x =
        rests * (1.0 - std::exp(-fades * t) * (std::cos(swings * t) + fades / swings * std::sin(swings * t)));
    CAPTURE(inertia, stiffness, t);
    CHECK(std::abs(q(static_cast<Eigen::Index>(k), 0) - (0.5 * force * t * t - inertia * x) / (inertia + mass)) < 2e-6);
  }
  const HiddenStates then =
      machine.hidden_after(machine.hidden_at_rest(), time, states.leftCols(1), states.rightCols(1), drives, 0, 200);
  CHECK(inertia * then.effects[1] + mass * states(200, 1) == Approx(force * time.back()).epsilon(1e-3));
}
