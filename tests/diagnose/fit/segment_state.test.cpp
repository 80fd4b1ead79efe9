// Initial states of segments: least squares in closed form, what is known of hidden states and what is not.

#include "diagnose/fit/segment_state.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "base/random.hpp"
#include "diagnose/settings.hpp"
#include "physics/catalogue.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/linearised.hpp"

using namespace bayesctrl;
using testing::largest_difference, testing::recorded;

namespace {

constexpr double kLeft = 1e-5;  // of the way to a minimum: what the damping of a single step leaves of it

Eigen::MatrixXd normal_matrix(RandomStream& random, Eigen::Index rows, Eigen::Index columns) {
  Eigen::MatrixXd matrix(rows, columns);
  for (double& x : matrix.reshaped()) x = draw_normal(random);
  return matrix;
}

/// A machine with `hidden` effects that have a state each, and perhaps a lag or a play in joint 0.
Machine with_states(const Plant& plant, int hidden, bool lag, bool play) {
  std::vector<Effect> effects;
  for (int i = 0; i < hidden; ++i) effects.push_back({PreslidingHysteresis{}, i % joints(plant), -1});
  if (lag) effects.push_back({ActuatorLag{}, 0, -1});
  if (play) effects.push_back({Backlash{}, 0, -1});
  return {plant, effects};
}

}  // namespace

TEST_CASE("Where the residual is linear in the initial state, what is found is ordinary least squares",
          "[diagnose][fit]") {
  RandomStream random(11);
  for (const Eigen::Index states : {2, 4, 8}) {
    for (const Eigen::Index joint_count : {1, 2}) {
      const Eigen::MatrixXd design = normal_matrix(random, 30 * joint_count, states);
      const Eigen::VectorXd measured = normal_matrix(random, design.rows(), 1);
      const auto residual = [&](const SegmentState& x) -> Eigen::MatrixXd {
        return (measured - design * x).reshaped(30, joint_count);
      };
      const SegmentState start = 10.0 * normal_matrix(random, states, 1);
      const SegmentState found = fit_initial_state(residual, start, 8, SegmentState::Zero(states)).start;
      const Eigen::VectorXd expected = testing::dense::least_squares(design, measured);
      CAPTURE(states, joint_count);
      CHECK(largest_difference(found, expected) < kLeft * (start - expected).norm());
    }
  }
}

TEST_CASE("The first position and speed of a slide are those of the regression on its closed form", "[diagnose][fit]") {
  const double mass = 1.7, friction = 0.9, noise = 0.01;
  const Machine slide(Mass{mass, friction}, {});
  const testing::Recorded made = recorded(slide, {.seconds = 2.0, .noise = noise, .seed = 3});
  const auto drives = drives_of(slide, made.data);
  const std::size_t last = made.data.samples() - 1;
  const auto residual = [&](const SegmentState& x) -> Eigen::MatrixXd {
    return made.data.position - slide.run(x, made.data.time, drives, 0, last, 1e-3, {{}, JointVector::Zero(1)});
  };
  // q = q0 + v0 m/c (1 - exp(-c t / m)) + the answer to the input, which is that of rest at 0.
  const Eigen::VectorXd forced = made.data.position - residual(SegmentState::Zero(2));
  Eigen::MatrixXd design(forced.size(), 2);
  for (Eigen::Index k = 0; k < design.rows(); ++k) {
    const double t = made.data.time[static_cast<std::size_t>(k)];
    design.row(k) << 1.0, mass / friction * -std::expm1(-friction * t / mass);
  }
  const Eigen::VectorXd expected = testing::dense::least_squares(design, made.data.position - forced);
  const SegmentState start{{1.0, -2.0}};
  const SegmentRun found = fit_initial_state(residual, start, 8, SegmentState::Zero(2));
  CHECK(largest_difference(found.start, expected) < kLeft * (start - expected).norm());
  CHECK(found.residual == residual(found.start));
}

TEST_CASE("What is known of an initial state weighs as much as samples with the noise that is left",
          "[diagnose][fit]") {
  RandomStream random(12);
  const Eigen::MatrixXd design = normal_matrix(random, 40, 3);
  const Eigen::VectorXd measured = design * Eigen::VectorXd::Constant(3, 2.0) + normal_matrix(random, 40, 1);
  const auto residual = [&](const SegmentState& x) -> Eigen::MatrixXd { return measured - design * x; };
  for (const double known : {0.0, 1.0, 100.0, 1e8}) {
    SegmentState precision = SegmentState::Zero(3);
    precision[2] = known;
    const SegmentState found = fit_initial_state(residual, SegmentState::Zero(3), 50, precision).start;
    const double variance = residual(found).squaredNorm() / 40.0;
    Eigen::MatrixXd hessian = design.transpose() * design;
    hessian(2, 2) += known * variance;
    const Eigen::VectorXd expected = testing::dense::solve(hessian, design.transpose() * measured);
    CAPTURE(known, found.transpose(), expected.transpose());
    const Eigen::VectorXd off = found - expected;
    CHECK(off.dot(hessian * off) < 2.0 * kSettings.fit.segment_gain * residual(found).squaredNorm());
  }
  const SegmentState once = weights_of(SegmentState{{0.0, 3.0}}, Eigen::MatrixXd::Constant(5, 2, 0.2));
  CHECK(largest_difference(once, Eigen::Vector2d(0.0, 3.0 * 0.04)) < 1e-15);
}

TEST_CASE("An initial state from which nothing can be simulated is refused, one next to such a state is kept",
          "[diagnose][fit]") {
  const auto beyond = [](double edge) {
    return [edge](const SegmentState& x) -> Eigen::MatrixXd {
      if (x[0] > edge) throw NumericalError("diverges");
      return Eigen::MatrixXd::Constant(4, 1, 5.0 - x[0]);
    };
  };
  CHECK_THROWS_AS(fit_initial_state(beyond(1.0), SegmentState{{1.5}}, 8, SegmentState::Zero(1)), NumericalError);
  const SegmentState found = fit_initial_state(beyond(3.0), SegmentState{{0.0}}, 50, SegmentState::Zero(1)).start;
  CHECK(found[0] <= 3.0);
  CHECK(found[0] > 1.5);  // as near to 5 as it could get by shortened steps
  CHECK(fit_initial_state(beyond(1.0), SegmentState{{0.7}}, 0, SegmentState::Zero(1)).start[0] == 0.7);
}

TEST_CASE("A first guess holds hidden states, lags and plays where nothing is known of before, nowhere else",
          "[diagnose][fit]") {
  const Plant plant = GENERATE(Plant(Pendulum{}), Plant(TwoLinkArm{}));
  const int n = joints(plant);
  Trajectory path;
  path.position = Eigen::MatrixXd::Random(20, n);
  path.velocity = Eigen::MatrixXd::Random(20, n);
  for (const int hidden : {0, 1, 3}) {
    for (const auto& [lag, play] : {std::pair{false, false}, {false, true}, {true, false}, {true, true}}) {
      for (const bool opens : {false, true}) {
        const Machine machine = with_states(plant, hidden, lag, play);
        const Segment window{0, 7, 19, opens};
        const SegmentState start = initial_guess(window, path, machine);
        const bool unknown = opens && (hidden > 0 || lag || play);
        CAPTURE(n, hidden, lag, play, opens);
        REQUIRE(start.size() == 2 * n + (unknown ? hidden + 2 * n : 0));
        CHECK(start.head(n).transpose() == path.position.row(7));
        CHECK(start.segment(n, n).transpose() == path.velocity.row(7));
        CHECK(start.tail(start.size() - 2 * n).isZero(0.0));
      }
    }
  }
}

TEST_CASE("A first guess shows what was measured, behind every sensor", "[diagnose][fit]") {
  Trajectory path;
  path.position = Eigen::MatrixXd::Random(20, 2);
  path.velocity = Eigen::MatrixXd::Random(20, 2);
  const std::vector<Effect> sensors{{SensorScale{0.83}, 0, -1}, {SensorOffset{0.2}, 1, -1}, {SensorScale{1.2}, 1, -1}};
  const Machine machine(TwoLinkArm{}, sensors);
  const SegmentState start = initial_guess({0, 7, 19, true}, path, machine);
  CHECK(largest_difference(machine.measured(start.head(2)), path.position.row(7).transpose()) < 1e-15);
  const JointVector shown = start.tail(2).cwiseProduct(JointVector{{0.83, 1.2}});
  CHECK(largest_difference(shown, path.velocity.row(7).transpose()) < 1e-15);
}

TEST_CASE("Hidden states are those of the initial state where it has them, else what is known of them",
          "[diagnose][fit]") {
  const HiddenStates known{HiddenVector{{1.0, 2.0}}, JointVector{{3.0, 4.0}}};
  const SegmentState plain{{0.0, 0.0, 0.0, 0.0}}, full{{0.0, 0.0, 0.0, 0.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0}};
  const auto of = [&](const SegmentState& start) {
    const HiddenStates found = hidden_states_of(start, known);
    Eigen::VectorXd all(4);
    all << found.effects, found.lags;
    return all;
  };
  CHECK(of(plain) == Eigen::Vector4d(1.0, 2.0, 3.0, 4.0));
  CHECK(of(full) == Eigen::Vector4d(5.0, 6.0, 7.0, 8.0));
  CHECK(plays_of(plain, 2).size() == 0);
  CHECK(plays_of(full, 2) == Eigen::Vector2d(9.0, 10.0));
}

TEST_CASE("A play stands where it is known to from that sample on, of held inputs and of straight ones",
          "[diagnose][fit]") {
  const Machine machine(kPendulum, {{Backlash{0.5}, 0, -1}});
  Measured data = recorded(machine, {}).data;
  data.linear_hold = GENERATE(false, true);
  const std::size_t at = 300;
  const double departure = GENERATE(-0.5, 0.2);
  const Drive before = drives_of(machine, data)[0],
              drive = drives_of(machine, data, {{at, JointVector{{departure}}}})[0];
  const auto index = [&](double t) {
    const std::vector<double>& times = drive.switches();
    return static_cast<std::size_t>(std::upper_bound(times.begin(), times.end(), t) - times.begin()) - 1;
  };
  const std::size_t first = index(data.time[at] + 1e-9);
  const double u = input_at(data, at, data.linear_hold ? 0.125 : 0.0)[0];
  CHECK(drive.at(first, data.time[at]) == Approx(u + departure).epsilon(1e-12));
  for (const std::size_t k : {std::size_t{0}, at - 1}) {
    CHECK(drive.at(index(data.time[k]), data.time[k]) == before.at(index(data.time[k]), data.time[k]));
  }
}

TEST_CASE("An initial state is handed down as far as both models have the same components", "[diagnose][fit]") {
  const auto handed = [](const SegmentState& found, SegmentState start) {
    hand_down(found, 1, start);
    return start;
  };
  const SegmentState plain{{1.0, 2.0}}, lag{{3.0, 4.0, 5.0, 5.5}}, hidden{{6.0, 7.0, 8.0, 9.0, 9.5}};
  CHECK(handed(plain, lag) == SegmentState{{1.0, 2.0, 5.0, 5.5}});
  CHECK(handed(lag, plain) == SegmentState{{3.0, 4.0}});
  CHECK(handed(lag, hidden) == SegmentState{{3.0, 4.0, 8.0, 5.0, 5.5}});
  CHECK(handed(hidden, lag) == SegmentState{{6.0, 7.0, 9.0, 9.5}});
  CHECK(handed(hidden, SegmentState::Zero(5)) == hidden);
}

TEST_CASE("Of an initial state lags and plays are known a priori: within the range of their joint's input",
          "[diagnose][fit]") {
  Measured data{"test", {0.0, 0.1, 0.2, 0.3}, {}, Eigen::MatrixXd(4, 2), 0.0, false};
  data.input << 1.0, 0.0, -3.0, 0.0, 1.0, 0.0, -3.0, 0.0;
  CHECK(precision_of(SegmentState::Zero(4), data).isZero(0.0));
  const SegmentState full = precision_of(SegmentState::Zero(9), data);
  REQUIRE(full.size() == 9);
  CHECK(full.head(5).isZero(0.0));
  for (const int i : {5, 7}) CHECK(full[i] == Approx(4.0 / 20.0));
  for (const int i : {6, 8}) CHECK(full[i] == 1e12);  // an input that is always 0 leaves nothing to be off by
}

TEST_CASE("Each recording's machine has the effects that act in it", "[diagnose][fit]") {
  const Effect always{ViscousFriction{}, 0, -1}, first{TorqueStep{}, 0, 0}, third{ConstantBias{}, 0, 2};
  const std::vector<Machine> list = machines(Pendulum{}, {third, always, first}, std::vector<Measured>(3));
  REQUIRE(list.size() == 3);
  CHECK(list[0].effects() == std::vector<Effect>{always, first});
  CHECK(list[1].effects() == std::vector<Effect>{always});
  CHECK(list[2].effects() == std::vector<Effect>{third, always});
}

TEST_CASE("An input that runs straight from sample to sample gives the momentum of its trapezoids", "[diagnose][fit]") {
  const double mass = 2.5;
  const Machine slide(Mass{mass, 0.0}, {});
  Measured data = recorded(slide, {.seconds = 1.0, .period = 0.05}).data;
  for (std::size_t k = 0; k < data.samples(); ++k) data.time[k] += 0.02 * std::sin(static_cast<double>(k));  // uneven
  data.linear_hold = GENERATE(false, true);
  CAPTURE(data.linear_hold);
  Eigen::MatrixXd states;
  slide.run(StateVector::Zero(2), data.time, drives_of(slide, data), 0, data.samples() - 1, 1e-3,
            {{}, JointVector::Zero(1)}, &states);
  double speed = 0.0, position = 0.0, largest = 0.0, far = 0.0;
  for (std::size_t k = 0; k + 1 < data.samples(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    const double h = data.time[k + 1] - data.time[k], u = data.input(row, 0) / mass;
    const double slope = data.linear_hold ? (data.input(row + 1, 0) / mass - u) / h : 0.0;
    position += h * speed + h * h / 2.0 * u + h * h * h / 6.0 * slope;
    speed += h * u + h * h / 2.0 * slope;
    largest = std::max(largest, std::abs(states(row + 1, 1) - speed));
    far = std::max(far, std::abs(states(row + 1, 0) - position));
  }
  CHECK(largest < 1e-12);
  CHECK(far < (data.linear_hold ? 2e-5 : 1e-12));  // a staircase of four: h^3 slope / 192 in each step
}
