#pragma once

#include <cmath>
#include <vector>

#include "base/random.hpp"
#include "diagnose/recording/measured.hpp"
#include "physics/machine/machine.hpp"

namespace bayesctrl::testing {

inline const Plant kPendulum = Pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};
inline constexpr double kPendulumNoise = 3e-4;  // rad

/// 10 s of a machine with one joint that is let go, without input, sampled at 100 Hz with noise.
inline Measured let_go(const Machine& machine, double from, std::uint64_t seed) {
  RandomStream random(seed);
  Measured data{"test", {}, {}, Eigen::MatrixXd::Zero(1000, 1), 0.0, false};
  for (int k = 0; k < 1000; ++k) data.time.push_back(0.01 * k);
  StateVector start(2);
  start << from, 0.0;
  data.position = machine.run(start, data.time, machine.drives(data.time, data.input), 0, 999, 1e-3);
  for (double& x : data.position.reshaped()) x += kPendulumNoise * draw_normal(random);
  return data;
}

/// 12 s of a machine with one joint under a sum of sines, `strength` times as strong, sampled at 100 Hz with noise;
/// half a second is lost from `gap` on (none if negative). A lag has settled on that `part` of the first input.
inline Measured record(const Machine& machine, double gap, std::uint64_t seed, double part = 1.0,
                       double strength = 1.0) {
  RandomStream random(seed);
  Measured data{"test", {}, {}, {}, 0.0, false};
  std::vector<double> time;
  Eigen::MatrixXd input(1200, 1);
  const double phase = draw_uniform(random, 0.0, 6.0);
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.01 * k;
    time.push_back(t);
    input(k, 0) = strength * (2.5 * std::sin(1.1 * t + phase) + 1.5 * std::sin(3.7 * t) + std::sin(7.9 * t + phase));
  }
  StateVector start(2);
  start << 0.3, 0.0;
  const HiddenStates hidden{{}, JointVector::Constant(1, (part - 1.0) * input(0, 0))};
  const Eigen::MatrixXd q = machine.run(start, time, machine.drives(time, input), 0, 1199, 1e-3, hidden);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < 1200; ++k) {
    const double t = time[static_cast<std::size_t>(k)];
    if (gap < 0.0 || t < gap || t >= gap + 0.5) kept.push_back(k);
  }
  data.position = q(kept, Eigen::all);
  data.input = input(kept, Eigen::all);
  for (const Eigen::Index k : kept) data.time.push_back(time[static_cast<std::size_t>(k)]);
  for (double& x : data.position.reshaped()) x += kPendulumNoise * draw_normal(random);
  return data;
}

/// What begins in the midst of the motion, `samples` later.
inline Measured without_beginning(Measured data, Eigen::Index samples) {
  const Eigen::Index left = data.position.rows() - samples;
  data.position = data.position.bottomRows(left).eval();
  data.input = data.input.bottomRows(left).eval();
  data.time.erase(data.time.begin(), data.time.begin() + samples);
  const double first = data.time.front();
  for (double& t : data.time) t -= first;
  return data;
}

}  // namespace bayesctrl::testing
