#pragma once

#include <Eigen/Core>
#include <cmath>

#include "base/random.hpp"
#include "diagnose/recording/measured.hpp"
#include "physics/plant.hpp"
#include "support/dense.hpp"

namespace bayesctrl::testing {

/// Two joints on springs, coupled by a third spring: x' = a x + b u with x = [q, v], solved by matrix exponentials.
struct LinearMachine {
  Plant plant = Custom({}, {"(u1 - 8*q1 - 0.4*v1 + 2*q2)/1.5", "(u2 - 5*q2 - 0.2*v2 + 2*q1)/0.5"}, {"1.5", "0.5"});
  Eigen::MatrixXd a = Eigen::MatrixXd{{0.0, 0.0, 1.0, 0.0},
                                      {0.0, 0.0, 0.0, 1.0},
                                      {-8.0 / 1.5, 2.0 / 1.5, -0.4 / 1.5, 0.0},
                                      {2.0 / 0.5, -5.0 / 0.5, 0.0, -0.2 / 0.5}};
  Eigen::MatrixXd mobility = Eigen::MatrixXd{{1.0 / 1.5, 0.0}, {0.0, 1.0 / 0.5}};

  /// State after h seconds: from a state, and from a constant acceleration of the joints.
  struct Step {
    Eigen::MatrixXd of_state, of_acceleration;
  };
  Step step(double h) const {
    Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(6, 6);
    rate.topLeftCorner(4, 4) = a;
    rate.block(2, 4, 2, 2).setIdentity();
    const Eigen::MatrixXd moved = dense::exponential(h * rate);
    return {moved.topLeftCorner(4, 4), moved.topRightCorner(4, 2)};
  }

  /// States [q, v] at every sample under the recording's held input and additional accelerations (samples x joints).
  Eigen::MatrixXd run(const Eigen::Vector4d& start, const Measured& data, const Eigen::MatrixXd& additional) const {
    Eigen::MatrixXd states(data.position.rows(), 4);
    states.row(0) = start.transpose();
    for (Eigen::Index k = 0; k + 1 < states.rows(); ++k) {
      const auto i = static_cast<std::size_t>(k);
      const Step s = step(data.time[i + 1] - data.time[i]);
      const Eigen::VectorXd push = mobility * data.input.row(k).transpose() + additional.row(k).transpose();
      states.row(k + 1) = (s.of_state * states.row(k).transpose() + s.of_acceleration * push).transpose();
    }
    return states;
  }
};

/// Standard deviations of the two sensors, rad.
inline Eigen::VectorXd linear_noise() { return Eigen::Vector2d(4e-4, 1e-3); }

/// Samples about `period` apart at times that jitter, under inputs that swing; positions are zero.
inline Measured linear_times(Eigen::Index samples, double period, RandomStream& random) {
  Measured data{"test", {}, Eigen::MatrixXd::Zero(samples, 2), Eigen::MatrixXd(samples, 2), 0.0, false};
  double t = 0.0;
  for (Eigen::Index k = 0; k < samples; ++k) {
    data.time.push_back(t);
    data.input.row(k) << 2.0 * std::sin(3.1 * t) + std::cos(7.3 * t), std::sin(4.3 * t + 1.0);
    t += period * draw_uniform(random, 0.8, 1.2);
  }
  return data;
}

/// Positions that the sensors show of a motion.
inline void measure(Measured& data, const Eigen::MatrixXd& positions, const Eigen::VectorXd& noise,
                    RandomStream& random) {
  data.position = positions;
  for (Eigen::Index j = 0; j < data.position.cols(); ++j) {
    for (double& q : data.position.col(j)) q += noise[j] * draw_normal(random);
  }
}

}  // namespace bayesctrl::testing
