#pragma once

#include "diagnose/recording/measured.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// What a machine did between its samples, as far as positions tell: rows are samples, columns joints.
struct Trajectory {
  Eigen::MatrixXd position, velocity;  // mean, of what the sensors show
  Eigen::MatrixXd missing_torque;      // torque that the nominal lacks
  Eigen::MatrixXd velocity_sd, torque_sd;
};

/// Prior of the missing torque, one per joint: an Ornstein-Uhlenbeck process (Matern of order 1/2).
struct TorquePrior {
  double deviation = 1.0;    // stationary standard deviation, N m
  double correlation = 0.3;  // s
};

/// State and missing torque d(t) together, q'' = nominal(q, v, u) + M^-1 d: an extended Kalman filter and the
/// Rauch-Tung-Striebel smoother; linear in the number of samples. `noise`: standard deviation per joint.
Trajectory smooth(const Plant& plant, const Measured& data, const Eigen::VectorXd& noise,
                  const std::vector<TorquePrior>& prior);

/// The prior under which the recordings are most likely.
std::vector<TorquePrior> likely_torque_prior(const Plant& plant, const std::vector<Measured>& data,
                                             const Eigen::VectorXd& noise);

/// All recordings under that prior.
std::vector<Trajectory> smooth_all(const Plant& plant, const std::vector<Measured>& data, const Eigen::VectorXd& noise);

/// RMS of the torque that accelerates the nominal along its recordings and of its input, per joint: a scale.
Eigen::VectorXd torque_scale(const Plant& plant, const std::vector<Measured>& data);

/// Input during the step from sample k on at the fraction `s` of it.
JointVector input_at(const Measured& data, std::size_t k, double s);

/// q, v after `h` seconds under a constant input and additional acceleration, by one Runge-Kutta step.
void propagate(const Plant& plant, JointVector& q, JointVector& v, const Measured& data, std::size_t k,
               const JointVector& missing_torque);

}  // namespace bayesctrl
