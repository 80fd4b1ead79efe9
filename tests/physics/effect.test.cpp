// The catalogue of effects against closed forms: motion under friction, hidden states, input effects.

#include "physics/effect.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "physics/catalogue.hpp"
#include "physics/machine/free_run.hpp"
#include "physics/machine/machine.hpp"

using namespace bayesctrl;

namespace {

constexpr double kRounding = 1e-12;
constexpr double kRungeKutta = 1e-8;  // of the integration at steps of 5 ms, for motions of about 1 rad

std::vector<double> grid(double duration, double dt) {
  std::vector<double> time;
  for (int k = 0; k * dt <= duration + 0.5 * dt; ++k) time.push_back(k * dt);
  return time;
}

/// Positions of a free run of one joint under a constant input.
Eigen::VectorXd positions(const Machine& machine, double q, double v, double input, const std::vector<double>& time) {
  const Eigen::MatrixXd inputs = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(time.size()), 1, input);
  StateVector start(2);
  start << q, v;
  return machine.run(start, time, machine.drives(time, inputs), 0, time.size() - 1);
}

const Plant kSlide = Mass{2.0, 0.0};

}  // namespace

TEST_CASE("The catalogue holds every effect of the contract once, with a sentence and required parameters",
          "[effects]") {
  std::set<std::string_view> names;
  for_each_effect([&]<class E>(E form) {
    CHECK(names.insert(E::kName).second);
    CHECK(!E::kText.empty());
    int parameters = 0;
    E::fields(form, [&](std::string_view, const double& value, const Info& info) {
      ++parameters;
      CHECK(info.required);
      CHECK(info.range.contains(value));
    });
    CHECK(parameters > 0);
    const EffectRoles& r = EffectForm(form).roles();
    INFO(E::kName);
    CHECK(r.torque + r.dry_friction + r.hidden_state + r.inertia + r.tilt + r.delay + r.map + r.play + r.lag +
              r.sensor ==
          1);
  });
  CHECK(names.size() == 34);
}

TEST_CASE("Dry friction brings a slide to rest after v^2 / (2 level/m), between two samples, and holds it there",
          "[effects]") {
  const Machine machine(kSlide, {{CoulombFriction{3.0}}});
  const std::vector<double> time = grid(2.0, 0.1);
  const double deceleration = 3.0 / 2.0, v = 1.0;  // stops at t = 0.667 s
  const Eigen::VectorXd q = positions(machine, 0.0, v, 0.0, time);
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = std::min(time[k], v / deceleration);
    CHECK(q[static_cast<Eigen::Index>(k)] == Approx(v * t - 0.5 * deceleration * t * t).margin(kRounding));
  }
}

TEST_CASE("A joint at rest stays exactly there up to the holding torque, and breaks away beyond it", "[effects]") {
  const std::vector<double> time = grid(1.0, 0.01);
  for (const EffectForm& form : {EffectForm{CoulombFriction{3.0}}, EffectForm{StribeckFriction{2.0, 3.0, 0.1}}}) {
    const Machine machine(kSlide, {{form}});
    CHECK(positions(machine, 0.4, 0.0, 2.999, time).cwiseAbs().maxCoeff() == 0.4);
    CHECK(positions(machine, 0.4, 0.0, 3.001, time).tail(1)[0] > 0.4);
    CHECK(positions(machine, 0.4, 0.0, -3.001, time).tail(1)[0] < 0.4);
  }
}

TEST_CASE("A slide pushed against its motion stops, turns and leaves with friction reversed", "[effects]") {
  const Machine machine(kSlide, {{CoulombFriction{1.0}}});
  const std::vector<double> time = grid(3.0, 0.05);
  const Eigen::VectorXd q = positions(machine, 0.0, 1.0, -4.0, time);  // -5/2 until it turns, -3/2 after
  const double turn = 1.0 / 2.5, top = 0.5 / 2.5;
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = time[k];
    const double expected = t < turn ? t - 1.25 * t * t : top - 0.75 * (t - turn) * (t - turn);
    CHECK(q[static_cast<Eigen::Index>(k)] == Approx(expected).margin(1e-11));
  }
}

TEST_CASE("A joint that is being stopped dead by a friction beyond its inertia neither creeps nor hangs", "[effects]") {
  const Machine machine(Mass{1e-3, 0.0}, {{CoulombFriction{50.0}}});
  const Eigen::VectorXd q = positions(machine, 0.0, 1.0, 10.0, grid(0.1, 0.01));
  CHECK(q[1] == Approx(0.5e-3 / 40.0).epsilon(1e-9));  // v^2 m / (2 (50 - 10)), then held
  CHECK(q.tail(1)[0] == q[1]);
}

TEST_CASE("Presliding friction is a spring before it slides, and its level while sliding", "[effects]") {
  const double stiffness = 200.0, level = 1.0;
  const Machine machine(kSlide, {{PreslidingHysteresis{stiffness, level}}});
  const double small = 1e-5, frequency = std::sqrt(stiffness / 2.0);
  const std::vector<double> time = grid(0.5, 0.01);
  const Eigen::VectorXd q = positions(machine, 0.0, small * frequency, 0.0, time);
  for (Eigen::Index k = 0; k < q.size(); ++k) {  // Dahl's law departs from a spring by q stiffness / level, 0.2 %
    CHECK(q[k] == Approx(small * std::sin(frequency * time[static_cast<std::size_t>(k)])).margin(5e-3 * small));
  }
  const Eigen::VectorXd fast = positions(machine, 0.0, 5.0, level, time);  // driven by its own level: no acceleration
  const Eigen::Index n = fast.size();
  CHECK(fast[n - 1] - 2.0 * fast[n - 2] + fast[n - 3] == Approx(0.0).margin(1e-10));
}

TEST_CASE("A late input is zero until it arrives, then the same input shifted", "[effects]") {
  const double delay = 0.034;  // between samples
  const Machine machine(kSlide, {{InputDelay{delay}}});
  const std::vector<double> time = grid(0.5, 0.01);
  const Eigen::VectorXd q = positions(machine, 0.0, 0.0, 2.0, time);
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = std::max(0.0, time[k] - delay);
    CHECK(q[static_cast<Eigen::Index>(k)] == Approx(0.5 * t * t).margin(kRounding));
  }
}

TEST_CASE("Behind a lag a step of the input arrives as 1 - exp(-t / time_constant)", "[effects]") {
  const double lag = 0.05, force = 2.0;
  const std::vector<double> time = grid(0.5, 0.01);
  const std::vector<double> step = [&] {
    std::vector<double> u(time.size(), force);
    u[0] = 0.0;
    return u;
  }();
  const Drive drive(time, step, {{ActuatorLag{lag}}}, 0);
  for (std::size_t k = 1; k < time.size(); ++k) {
    CHECK(drive.at(k, time[k]) == Approx(force * (1.0 - std::exp(-(time[k] - time[1]) / lag))).margin(kRounding));
  }
}

TEST_CASE("A lag that begins elsewhere comes to where the input is", "[effects]") {
  const double lag = GENERATE(1e-5, 1e-4, 1e-3, 0.02, 0.2, 2.0), force = 2.0;
  const Machine machine(Mass{1.0, 0.0}, {{ActuatorLag{lag}}});
  const std::vector<double> time = grid(1.0, 0.01);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(time.size()), 1, force);
  const JointVector idle = JointVector::Constant(1, -force);
  const Eigen::MatrixXd q =
      machine.run(StateVector::Zero(2), time, machine.drives(time, input), 0, time.size() - 1, 0.005, {{}, idle});
  for (std::size_t k = 0; k < time.size(); ++k) {  // v' = force (1 - exp(-t / lag))
    const double t = time[k], moved = 0.5 * t * t - lag * t - lag * lag * std::expm1(-t / lag);
    CHECK(q(static_cast<Eigen::Index>(k), 0) == Approx(force * moved).margin(kRounding));
  }
  const Eigen::MatrixXd still = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(time.size()), 1);
  const HiddenStates later = machine.hidden_after({{}, idle}, time, still, still, machine.drives(time, input), 20, 70);
  CHECK(later.lags[0] == Approx(-force * std::exp(-(time[70] - time[20]) / lag)).margin(1e-300));
}

TEST_CASE("Behind a lag steps need not be finer than the motion asks for", "[effects]") {
  const double lag = GENERATE(3e-4, 1e-3, 5e-3, 0.03);
  const Machine machine(Pendulum{}, {{ActuatorLag{lag}}, {CoulombFriction{0.2}}});
  const std::vector<double> time = grid(3.0, 0.01);
  Eigen::MatrixXd input(static_cast<Eigen::Index>(time.size()), 1);
  for (Eigen::Index k = 0; k < input.rows(); ++k) input(k, 0) = k / 20 % 2 == 0 ? 2.0 : -1.5;
  const auto run = [&](double step) {
    const StateVector start = StateVector{{0.4, 1.0}};
    return machine.run(start, time, machine.drives(time, input), 0, time.size() - 1, step);
  };
  CHECK((run(5e-3) - run(1e-4)).cwiseAbs().maxCoeff() < 1e-5);
}

TEST_CASE("Of what acts in one recording a law of that recording says nothing of new ones, all else stays",
          "[effects]") {
  const std::vector<Effect> effects{{TorqueStep{0.3, 1.0}, 0, 1},
                                    {RecordingGain{{0.8}}, 0, 1},
                                    {RecordingOffset{{0.1}}, 0, 0},
                                    {ViscousFriction{}, 0, -1}};
  CHECK(acting_in(effects, 0) == std::vector<Effect>{effects[2], effects[3]});
  CHECK(acting_in(effects, 1) == std::vector<Effect>{effects[0], effects[1], effects[3]});
  CHECK(in_new_recordings(effects) == std::vector<Effect>{{TorqueStep{0.3, 1.0}, 0, -1}, effects[3]});
  CHECK(same_place(effects[0], {TorqueStep{}, 0, 2}));
  CHECK_FALSE(same_place(effects[1], {RecordingGain{}, 0, 2}));
}

TEST_CASE("The load of friction holds springs and gravity as the machine stands", "[effects]") {
  const double k = 0.1, stiffness = 50.0, mass = 2.0;
  const Machine slide(Mass{mass, 0.0}, {{LoadDependentFriction{k}}, {LinearSpring{stiffness}}});
  const std::vector<double> time = grid(0.25, 0.01);
  const Eigen::VectorXd q = positions(slide, 1.0, 0.0, 0.0, time);
  const double frequency = std::sqrt(stiffness * (1.0 - k) / mass);  // on its way back friction takes a tenth
  for (std::size_t i = 0; i < time.size(); ++i) {
    CHECK(q[static_cast<Eigen::Index>(i)] == Approx(std::cos(frequency * time[i])).margin(kRungeKutta));
  }
  const Pendulum pendulum{.length = 1.0, .friction = 0.0, .mass = 0.5};
  const double tilt = 0.3;
  const Machine upright(pendulum, {{LoadDependentFriction{k}}});
  const Machine tilted(pendulum, {{LoadDependentFriction{k}}, {GravityTilt{tilt}}});
  CHECK((positions(tilted, 0.5 - tilt, 0.4, 0.7, time) - positions(upright, 0.5, 0.4, 0.7, time))
            .array()
            .isApproxToConstant(-tilt, 1e-10));
  // Pulled by a spring as hard as by a motor it holds the same.
  CHECK(positions(slide, 0.0, 0.0, 0.0, time).isZero(0.0));
}

TEST_CASE("Input effects act in the catalogue's order whatever the order of the list, each in its own joint",
          "[effects]") {
  const std::vector<double> time{0.0, 1.0, 2.0}, input{1.0, 5.0, -5.0};
  const std::vector<Effect> effects{
      {InputSaturation{3.0}}, {InputDeadZone{0.5}}, {InputGain{2.0}}, {InputGain{10.0}, 1}};
  const Drive drive(time, input, effects, 0);
  CHECK(drive.at(0, 0.5) == Approx(1.5));  // 2 * 1 - 0.5
  CHECK(drive.at(1, 1.0) == 3.0);
  CHECK(drive.at(2, 2.0) == -3.0);
}

TEST_CASE("A play follows only at the ends of its gap", "[effects]") {
  const std::vector<double> time{0, 1, 2, 3, 4}, input{0.1, 1.0, 0.7, 0.2, 0.5};
  const Drive drive(time, input, {{Backlash{0.3}}}, 0);
  const std::vector<double> expected{0.0, 0.7, 0.7, 0.5, 0.5};
  for (std::size_t k = 0; k < time.size(); ++k) CHECK(drive.at(k, time[k]) == Approx(expected[k]).margin(kRounding));
}

TEST_CASE("A torque step acts from its instant on, also between samples", "[effects]") {
  const Machine machine(kSlide, {{TorqueStep{2.0, 0.123}}});
  const std::vector<double> time = grid(0.5, 0.01);
  const Eigen::VectorXd q = positions(machine, 0.0, 0.0, 0.0, time);
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double t = std::max(0.0, time[k] - 0.123);
    CHECK(q[static_cast<Eigen::Index>(k)] == Approx(0.5 * t * t).margin(kRounding));
  }
}

TEST_CASE("Added inertia, tilt, scale and offset are the plant with other numbers", "[effects]") {
  const std::vector<double> time = grid(1.0, 0.01);
  const Pendulum pendulum{.length = 1.0, .friction = 0.2, .mass = 0.5};
  const auto difference = [&](const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    return (a - b).cwiseAbs().maxCoeff();
  };
  CHECK(difference(positions(Machine(kSlide, {{AddedInertia{0.5}}}), 0.0, 1.0, 3.0, time),
                   positions(Machine(Mass{2.5, 0.0}, {}), 0.0, 1.0, 3.0, time)) < kRounding);
  // Gravity at q + angle is the same pendulum, seen from an angle further on.
  const Eigen::VectorXd shifted = positions(Machine(pendulum, {}), 0.3 + 0.1, 0.0, 1.0, time);
  CHECK(difference(positions(Machine(pendulum, {{GravityTilt{0.1}}}), 0.3, 0.0, 1.0, time),
                   (shifted.array() - 0.1).matrix()) < kRungeKutta);
  const Eigen::VectorXd plain = positions(Machine(pendulum, {}), 0.3, 0.0, 1.0, time);
  CHECK(difference(positions(Machine(pendulum, {{SensorOffset{0.2}}}), 0.3, 0.0, 1.0, time),
                   (plain.array() + 0.2).matrix()) < kRounding);
  CHECK(difference(positions(Machine(pendulum, {{SensorScale{1.3}}}), 0.3, 0.0, 1.0, time), 1.3 * plain) < kRounding);
}

TEST_CASE("In an arm a stuck joint stands while the other one moves it about", "[effects]") {
  const TwoLinkArm arm;
  const Machine machine(arm, {{CoulombFriction{100.0}, 1}});
  const std::vector<double> time = grid(1.0, 0.01);
  const Eigen::MatrixXd inputs = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(time.size()), 2, 1.0);
  StateVector start(4);
  start << 0.2, 0.5, 0.0, 0.0;
  const Eigen::MatrixXd q = machine.run(start, time, machine.drives(time, inputs), 0, time.size() - 1);
  CHECK((q.col(1).array() == 0.5).all());
  CHECK(q.col(0).maxCoeff() - q.col(0).minCoeff() > 0.1);
}

TEST_CASE("A machine without effects moves as its plant does under Dormand-Prince", "[effects]") {
  const Pendulum pendulum{.length = 1.0, .friction = 0.2, .mass = 0.5};
  const std::vector<double> time = grid(2.0, 0.01);
  const Eigen::MatrixXd inputs = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(time.size()), 1, 0.7);
  StateVector start(2);
  start << 0.3, 1.0;
  const Recording exact = free_run(Model{pendulum}, start, time, inputs, {1e-12, 1e-12});
  CHECK((positions(Machine(pendulum, {}), 0.3, 1.0, 0.7, time) - exact.position.col(0)).cwiseAbs().maxCoeff() <
        kRungeKutta);
}

TEST_CASE("A coupling pulls a joint towards its neighbour: the same motion as of a machine that says so itself",
          "[effects]") {
  const Plant free = Custom({}, {"u1", "u2", "u3"}, {});
  const Plant coupled = Custom({}, {"u1 - 3*(q1 - q2)", "u2", "u3 - 2*(q3 - q2)"}, {});
  const Machine with(free, {{CouplingTorque{3.0}, 0, -1}, {CouplingTorque{2.0}, 2, -1}});
  const Machine same(coupled, {});
  const std::vector<double> time = grid(3.0, 0.01);
  const Eigen::MatrixXd input = Eigen::MatrixXd::Constant(static_cast<Eigen::Index>(time.size()), 3, 0.1);
  StateVector start(6);
  start << 0.5, -0.3, 0.2, 0.0, 1.0, -1.0;
  const Eigen::MatrixXd a = with.run(start, time, with.drives(time, input), 0, time.size() - 1);
  const Eigen::MatrixXd b = same.run(start, time, same.drives(time, input), 0, time.size() - 1);
  CHECK((a - b).cwiseAbs().maxCoeff() < 1e-12);
}
