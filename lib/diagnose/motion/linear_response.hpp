#pragma once

#include "diagnose/motion/smoother.hpp"

namespace bayesctrl {

/// The machine's response about a motion that is near the true one, in windows whose initial states are free: how far
/// an additional acceleration moves the measured positions. Positions are divided by the noise, projected on slow modes
/// of each window (polynomials and cosines) with what the initial state can do projected out, so that what is left is
/// white with variance 1 for a perfect model. Exact to first order in the distance between the two motions.
class LinearResponse {
 public:
  /// `fastest_mode`: Hz.
  LinearResponse(const Plant& plant, const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
                 const Eigen::VectorXd& noise, const std::vector<Segment>& windows, double fastest_mode = 10.0);

  Eigen::Index rows() const { return rows_; }

  /// Measured less simulated by the nominal.
  const Eigen::VectorXd& target() const { return target_; }

  /// Responses to accelerations, one column for each; `acceleration` [recording]: (samples * joints) x columns, the row
  /// of sample k and joint j is k * joints + j and holds from sample k to k + 1.
  Eigen::MatrixXd responses(const std::vector<Eigen::MatrixXd>& acceleration) const;

  /// What changes of the measured positions look like; layout as above.
  Eigen::MatrixXd measured(const std::vector<Eigen::MatrixXd>& positions) const;

  /// Noise per joint over the noise given, from the modes that are too fast for mechanics.
  const Eigen::VectorXd& noise_ratio() const { return noise_ratio_; }

  /// The same with process noise: a white acceleration of this intensity per joint (root of the spectral density,
  /// acceleration times root of time). Rows are then white for a model that lacks nothing else.
  LinearResponse with_process_noise(const Eigen::VectorXd& intensity) const;

  /// Logarithms of what each row was divided by when it was whitened: with half their squares the rows' likelihood.
  const Eigen::VectorXd& log_scale() const { return log_scale_; }

  /// Covariance of a window's rows by process noise of intensity 1 in one joint.
  Eigen::MatrixXd process_noise_covariance(std::size_t window, Eigen::Index joint) const;

  int joints() const { return joints_; }
  const std::vector<Segment>& windows() const { return windows_; }
  Eigen::Index first_row(std::size_t window) const { return offset_[window]; }
  Eigen::Index row_count(std::size_t window) const { return map_[window].rows(); }

  /// Positions of one window (samples x joints) on the response's rows of that window.
  Eigen::VectorXd project(std::size_t window, const Eigen::MatrixXd& positions) const;

  /// Change of the window's initial state [q, v] that explains `positions` best.
  StateVector initial_change(std::size_t window, const Eigen::MatrixXd& positions) const;

  /// `positions` of one window less what a change of its initial state explains best: projected on what it cannot do.
  Eigen::MatrixXd initial_state_projected_out(std::size_t window, const Eigen::MatrixXd& positions) const;

 private:
  int joints_;
  std::vector<Segment> windows_;
  std::vector<Eigen::Index> offset_;               // first row of each window
  std::vector<Eigen::VectorXd> steps_;             // per window: s, of its samples
  std::vector<Eigen::MatrixXd> map_;               // per window: rows x (steps * joints)
  std::vector<Eigen::MatrixXd> projection_;        // per window: rows x (samples * joints), the same order
  std::vector<Eigen::MatrixXd> start_;             // per window: states x (samples * joints), least squares,
  std::vector<Eigen::MatrixXd> by_initial_state_;  // and (samples * joints) x states, what it does to positions
  Eigen::VectorXd target_, log_scale_;
  Eigen::VectorXd noise_ratio_;
  Eigen::Index rows_ = 0;
};

}  // namespace bayesctrl
