// The smoother against the dense Gaussian conditional of a linear machine, and that its bands hold what they promise.

#include "diagnose/motion/smoother.hpp"

#include <catch2/catch.hpp>
#include <numbers>

#include "diagnose/motion/linear_machine.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"

using namespace bayesctrl;
using testing::LinearMachine, testing::linear_noise, testing::linear_times, testing::measure;

namespace {

/// Of [q, v, d] over h seconds: transition, what a constant input adds, and covariance of what the torques d, which are
/// Ornstein-Uhlenbeck processes, add (Van Loan, Computing integrals involving the matrix exponential, 1978).
struct Transition {
  Eigen::MatrixXd of_state, of_input, noise;
};
Transition transition(const LinearMachine& machine, const std::vector<TorquePrior>& prior, double h) {
  Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(6, 6), density = rate;
  rate.topLeftCorner(4, 4) = machine.a;
  rate.block(2, 4, 2, 2) = machine.mobility;
  for (Eigen::Index j = 0; j < 2; ++j) {
    const TorquePrior& of = prior[static_cast<std::size_t>(j)];
    rate(4 + j, 4 + j) = -1.0 / of.correlation;
    density(4 + j, 4 + j) = 2.0 * of.deviation * of.deviation / of.correlation;
  }
  Eigen::MatrixXd both = Eigen::MatrixXd::Zero(12, 12);
  both << -rate, density, Eigen::MatrixXd::Zero(6, 6), rate.transpose();
  const Eigen::MatrixXd moved = testing::dense::exponential(h * both);
  const Eigen::MatrixXd of_state = moved.bottomRightCorner(6, 6).transpose();
  Eigen::MatrixXd of_input = Eigen::MatrixXd::Zero(6, 2);
  of_input.topRows(4) = machine.step(h).of_acceleration * machine.mobility;
  return {of_state, of_input, of_state * moved.topRightCorner(6, 6)};
}

/// What the positions say of all samples at once: mean and deviation of [q, v, d] (samples x 6), and their likelihood.
struct Conditional {
  Eigen::MatrixXd mean, sd;
  double log_likelihood;
};
Conditional conditional(const LinearMachine& machine, const Measured& data, const Eigen::VectorXd& noise,
                        const std::vector<TorquePrior>& prior) {
  const Eigen::Index samples = data.position.rows(), size = 6 * samples;
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(size);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(size, size), seen = Eigen::MatrixXd::Zero(2 * samples, size);
  Eigen::VectorXd variance(6);
  variance << 1.0, 1.0, 9.0, 9.0, std::pow(prior[0].deviation, 2), std::pow(prior[1].deviation, 2);
  covariance.topLeftCorner(6, 6) = variance.asDiagonal();
  Eigen::VectorXd rest(2 * samples), white(2 * samples);
  for (Eigen::Index k = 0; k < samples; ++k) {
    if (k > 0) {
      const auto i = static_cast<std::size_t>(k);
      const Transition by = transition(machine, prior, data.time[i] - data.time[i - 1]);
      const Eigen::Index at = 6 * k, before = at - 6;
      mean.segment(at, 6) = by.of_state * mean.segment(before, 6) + by.of_input * data.input.row(k - 1).transpose();
      covariance.block(at, 0, 6, at) = by.of_state * covariance.block(before, 0, 6, at);
      covariance.block(0, at, at, 6) = covariance.block(at, 0, 6, at).transpose();
      covariance.block(at, at, 6, 6) =
          by.of_state * covariance.block(before, before, 6, 6) * by.of_state.transpose() + by.noise;
    }
    for (Eigen::Index j = 0; j < 2; ++j) {
      seen(2 * k + j, 6 * k + j) = 1.0;
      rest[2 * k + j] = data.position(k, j);
      white[2 * k + j] = noise[j] * noise[j];
    }
  }
  rest -= seen * mean;
  const Eigen::MatrixXd across = covariance * seen.transpose();
  const Eigen::MatrixXd of_rest = seen * across + Eigen::MatrixXd(white.asDiagonal());
  const Eigen::VectorXd posterior = mean + across * testing::dense::solve(of_rest, rest);
  const Eigen::MatrixXd known = across * testing::dense::solve(of_rest, across.transpose());
  const Eigen::VectorXd left = covariance.diagonal() - known.diagonal();
  return {posterior.reshaped(6, samples).transpose(), left.cwiseMax(0.0).cwiseSqrt().reshaped(6, samples).transpose(),
          testing::dense::log_density(rest, of_rest)};
}

/// A recording with its truth [q, v, d] (samples x 6): the missing torque is a draw of its prior.
struct Drawn {
  Measured data;
  Eigen::MatrixXd truth;
};
Drawn drawn(const LinearMachine& machine, const std::vector<TorquePrior>& prior, Eigen::Index samples, double period,
            std::uint64_t seed) {
  RandomStream random(seed);
  Drawn result{linear_times(samples, period, random), Eigen::MatrixXd(samples, 6)};
  const auto normal = [&](Eigen::Index size) {
    return Eigen::VectorXd(Eigen::VectorXd::NullaryExpr(size, [&](Eigen::Index) { return draw_normal(random); }));
  };
  Eigen::VectorXd x = 0.3 * normal(6);
  for (Eigen::Index j = 0; j < 2; ++j) x[4 + j] = prior[static_cast<std::size_t>(j)].deviation * draw_normal(random);
  for (Eigen::Index k = 0; k < samples; ++k) {
    result.truth.row(k) = x.transpose();
    if (k + 1 == samples) break;
    const auto i = static_cast<std::size_t>(k);
    const Transition by = transition(machine, prior, result.data.time[i + 1] - result.data.time[i]);
    const Eigen::MatrixXd root = testing::dense::square_root(by.noise);
    x = (by.of_state * x + by.of_input * result.data.input.row(k).transpose() + root * normal(6)).eval();
  }
  measure(result.data, result.truth.leftCols(2), linear_noise(), random);
  return result;
}

}  // namespace

TEST_CASE("Of a linear machine the smoother is the conditional of all samples at once", "[diagnose][motion]") {
  const LinearMachine machine;
  const double correlation = GENERATE(0.3, 1.0), strength = GENERATE(0.02, 0.2, 2.0);
  CAPTURE(correlation, strength);
  const std::vector<TorquePrior> prior{{strength, correlation}, {0.5 * strength, correlation}};
  const Drawn example = drawn(machine, prior, 160, 0.004, 3);
  const Conditional expected = conditional(machine, example.data, linear_noise(), prior);
  const Trajectory found = smooth(machine.plant, example.data, linear_noise(), prior);
  Eigen::MatrixXd mean(160, 6), sd(160, 4);
  mean << found.position, found.velocity, found.missing_torque;
  sd << found.velocity_sd, found.torque_sd;
  const Eigen::MatrixXd off = (mean - expected.mean).cwiseQuotient(expected.sd);
  CHECK(off.leftCols(4).cwiseAbs().maxCoeff() < 0.03);
  CHECK(off.rightCols(2).cwiseAbs().maxCoeff() < 0.1);  // its steps hold the torque
  CHECK((sd.cwiseQuotient(expected.sd.rightCols(4)).array() - 1.0).abs().maxCoeff() < 0.01);
}

TEST_CASE("The torque's prior is the most likely of eight by the density of all samples at once",
          "[diagnose][motion][slow]") {
  const LinearMachine machine;
  for (const double strength : {0.0, 0.02, 0.5}) {
    CAPTURE(strength);
    const Drawn example = drawn(machine, {{strength, 0.3}, {strength, 0.3}}, 120, 0.005, 5);
    const Eigen::VectorXd scale = torque_scale(machine.plant, {example.data});
    std::vector<TorquePrior> best;
    double highest = -kInfinity;
    for (int i = 0; i < 8; ++i) {
      const double part = std::pow(10.0, -3.5 + 0.5 * i);
      const std::vector<TorquePrior> prior{{part * scale[0], 0.3}, {part * scale[1], 0.3}};
      const double likelihood = conditional(machine, example.data, linear_noise(), prior).log_likelihood;
      if (likelihood > highest) best = prior;
      highest = std::max(highest, likelihood);
    }
    const std::vector<TorquePrior> found = likely_torque_prior(machine.plant, {example.data}, linear_noise());
    REQUIRE(found.size() == 2);
    for (std::size_t j = 0; j < 2; ++j) {
      CHECK(found[j].deviation == Approx(best[j].deviation));
      CHECK(found[j].correlation == best[j].correlation);
    }
    if (strength == 0.0) CHECK(found[0].deviation < 2e-3 * scale[0]);  // nothing is missing
  }
}

TEST_CASE("Where sensors say nothing the missing torque is what it was taken for", "[diagnose][motion]") {
  const LinearMachine machine;
  RandomStream random(7);
  const Measured data = linear_times(300, 0.01, random);
  const std::vector<TorquePrior> prior{{0.3, 0.2}, {2.0, 1.5}};
  const Trajectory found = smooth(machine.plant, data, Eigen::VectorXd::Constant(2, 1e3), prior);
  CHECK(found.missing_torque.cwiseAbs().maxCoeff() < 1e-3);
  for (Eigen::Index j = 0; j < 2; ++j) {
    const double deviation = prior[static_cast<std::size_t>(j)].deviation;
    CHECK(found.torque_sd.col(j).minCoeff() == Approx(deviation).epsilon(1e-3));
    CHECK(found.torque_sd.col(j).maxCoeff() == Approx(deviation).epsilon(1e-3));
  }
}

TEST_CASE("Bands about velocity and missing torque hold the truth as often as they say, also of a pendulum",
          "[diagnose][motion]") {
  const Pendulum pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};
  const double inertia = 0.6 * 0.8 * 0.8, period = 0.01, noise = 3e-4;
  constexpr int kRuns = 30, kFine = 10;
  const TorquePrior prior{0.4, 0.3};
  double squares_v = 0.0, squares_d = 0.0, count = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    RandomStream random(static_cast<std::uint64_t>(run));
    Measured data{"test", {}, Eigen::MatrixXd(300, 1), Eigen::MatrixXd(300, 1), 0.0, false};
    Eigen::VectorXd speed(300), torque(300);
    double q = 1.0, v = draw_uniform(random, -3.0, 3.0), d = prior.deviation * draw_normal(random);
    for (Eigen::Index k = 0; k < 300; ++k) {
      data.time.push_back(period * static_cast<double>(k));
      data.input(k, 0) = 2.0 * std::sin(2.0 * data.time.back());
      data.position(k, 0) = q + noise * draw_normal(random);
      speed[k] = v;
      torque[k] = d;
      const double h = period / kFine, decay = std::exp(-h / prior.correlation);
      for (int i = 0; i < kFine; ++i) {  // leapfrog
        const auto rate = [&](double at) {
          return -9.81 / 0.8 * std::sin(at) + (data.input(k, 0) + d - 0.2 * v) / inertia;
        };
        v += 0.5 * h * rate(q);
        q += h * v;
        v += 0.5 * h * rate(q);
        d = decay * d + prior.deviation * std::sqrt(1.0 - decay * decay) * draw_normal(random);
      }
    }
    const Trajectory found = smooth(pendulum, data, Eigen::VectorXd::Constant(1, noise), {prior});
    for (Eigen::Index k = 20; k < 300; k += 10) {
      squares_v += std::pow((found.velocity(k, 0) - speed[k]) / found.velocity_sd(k, 0), 2);
      squares_d += std::pow((found.missing_torque(k, 0) - torque[k]) / found.torque_sd(k, 0), 2);
      count += 1.0;
    }
  }
  CHECK(squares_v / count == Approx(1.0).margin(0.2));  // four standard deviations of independent ones
  CHECK(squares_d / count == Approx(1.0).margin(0.2));
}

TEST_CASE("Across a gap nothing is carried: each stretch is smoothed by itself", "[diagnose][motion]") {
  const LinearMachine machine;
  const std::vector<TorquePrior> prior{{0.2, 0.3}, {0.1, 0.3}};
  Measured whole = drawn(machine, prior, 200, 0.01, 11).data;
  const auto part = [&](Eigen::Index first, Eigen::Index count) {
    const auto from = whole.time.begin() + first;
    return Measured{
        "part", {from, from + count}, whole.position.middleRows(first, count), whole.input.middleRows(first, count)};
  };
  for (std::size_t k = 120; k < 200; ++k) whole.time[k] += 0.5;
  const Trajectory found = smooth(machine.plant, whole, linear_noise(), prior);
  for (const auto& [first, count] : {std::pair{0, 120}, std::pair{120, 80}}) {
    const Trajectory alone = smooth(machine.plant, part(first, count), linear_noise(), prior);
    CHECK(testing::largest_difference(found.position.middleRows(first, count), alone.position) < 1e-9);
    CHECK(testing::largest_difference(found.missing_torque.middleRows(first, count), alone.missing_torque) < 1e-9);
    CHECK(testing::largest_difference(found.torque_sd.middleRows(first, count), alone.torque_sd) < 1e-9);
  }
}

TEST_CASE("A step under a constant torque is exact to the fifth order of its length", "[diagnose][motion]") {
  const LinearMachine machine;
  const Eigen::Vector4d start(0.4, -0.3, 2.0, -3.0);
  const Eigen::Vector2d torque(0.7, -0.4);
  double before = 0.0;
  for (const double h : {0.16, 0.08, 0.04}) {
    Measured data{"test", {0.0, h}, Eigen::MatrixXd::Zero(2, 2), Eigen::MatrixXd::Ones(2, 2), 0.0, false};
    Eigen::MatrixXd additional = Eigen::MatrixXd::Zero(2, 2);
    additional.row(0) = (machine.mobility * torque).transpose();
    JointVector q = start.head(2), v = start.tail(2);
    propagate(machine.plant, q, v, data, 0, torque);
    Eigen::Vector4d found;
    found << q, v;
    const double error = (found - machine.run(start, data, additional).row(1).transpose()).norm();
    CHECK(error < std::pow(2.0 * h, 5));
    if (before > 0.0) CHECK(std::log2(before / error) == Approx(5.0).margin(0.3));
    before = error;
  }
}

TEST_CASE("The input within a step is the one held, or lies on the line to the next", "[diagnose][motion]") {
  Measured data{"test", {0.0, 0.1, 0.2}, Eigen::MatrixXd::Zero(3, 1), Eigen::VectorXd{{1.0, 3.0, -1.0}}, 0.0, false};
  for (const double s : {0.0, 0.25, 1.0}) CHECK(input_at(data, 1, s)[0] == 3.0);
  data.linear_hold = true;
  CHECK(input_at(data, 0, 0.25)[0] == Approx(1.5));
  CHECK(input_at(data, 1, 0.25)[0] == Approx(2.0));
  CHECK(input_at(data, 2, 0.25)[0] == -1.0);  // after the last there is no line
}

TEST_CASE("The scale of torques is that of the motor and of what the nominal does by itself", "[diagnose][motion]") {
  Measured data{"test", {}, Eigen::MatrixXd(400, 1), Eigen::MatrixXd(400, 1), 0.0, false};
  for (Eigen::Index k = 0; k < 400; ++k) {
    data.time.push_back(0.01 * static_cast<double>(k));
    data.position(k, 0) = 1.5 * data.time.back();
    data.input(k, 0) = 0.7;
  }
  const double moving = torque_scale(Mass{.mass = 3.0, .friction = 0.4}, {data})[0];
  CHECK(moving == Approx(std::hypot(0.7, 0.4 * 1.5)));
  data.position.setConstant(0.9);
  const Pendulum pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};
  CHECK(torque_scale(pendulum, {data})[0] == Approx(std::hypot(0.7, 0.6 * 9.81 * 0.8 * std::sin(0.9))));
}
