#include "diagnose/motion/linear_response.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

/// Orthonormal slow modes of one window, samples x modes.
Eigen::MatrixXd slow_modes(const std::vector<double>& time, const Segment& window, double fastest) {
  const auto samples = static_cast<Eigen::Index>(window.samples());
  const double length = time[window.last] - time[window.first];
  const auto wanted = static_cast<Eigen::Index>(kSettings.motion.polynomial_modes + 2.0 * fastest * length);
  const Eigen::Index count = std::max<Eigen::Index>(std::min(wanted, samples / 2), std::min<Eigen::Index>(samples, 4));
  Eigen::MatrixXd modes(samples, count);
  for (Eigen::Index i = 0; i < samples; ++i) {
    const double s = (time[window.first + static_cast<std::size_t>(i)] - time[window.first]) / length;
    const double x = 2.0 * s - 1.0;
    for (Eigen::Index m = 0; m < count; ++m) {
      modes(i, m) =
          m < kSettings.motion.polynomial_modes
              ? std::pow(x, m)
              : std::cos(std::numbers::pi * static_cast<double>(m - kSettings.motion.polynomial_modes + 2) * s);
    }
  }
  return orthonormal_basis(modes);
}

}  // namespace

LinearResponse::LinearResponse(const Plant& plant, const std::vector<Measured>& data,
                               const std::vector<Trajectory>& path, const Eigen::VectorXd& noise,
                               const std::vector<Segment>& windows, double fastest_mode)
    : joints_(bayesctrl::joints(plant)), windows_(windows) {
  const Eigen::Index n = joints_, states = 2 * n;
  constexpr double kStep = 1e-5;
  std::vector<Eigen::VectorXd> targets;
  Eigen::VectorXd fast = Eigen::VectorXd::Zero(n), fast_count = Eigen::VectorXd::Zero(n);
  for (const Segment& window : windows_) {
    const Measured& m = data[window.recording];
    const Trajectory& motion_of = path[window.recording];
    const auto samples = static_cast<Eigen::Index>(window.samples());
    const Eigen::MatrixXd modes = slow_modes(m.time, window, fastest_mode);
    const Eigen::Index count = modes.cols();

    // Transition of each step, and what the reference motion lacks to be one of the nominal.
    std::vector<Eigen::MatrixXd> phi(static_cast<std::size_t>(samples - 1)), gamma(phi.size());
    Eigen::VectorXd state = Eigen::VectorXd::Zero(states);
    Eigen::MatrixXd initial = Eigen::MatrixXd::Identity(states, states);  // d state / d initial state
    Eigen::MatrixXd rest(samples, n), free(samples * n, states);
    for (Eigen::Index i = 0; i < samples; ++i) {
      const std::size_t k = window.first + static_cast<std::size_t>(i);
      const auto row = static_cast<Eigen::Index>(k);
      rest.row(i) = (m.position.row(row) - motion_of.position.row(row) - state.head(n).transpose());
      for (Eigen::Index j = 0; j < n; ++j) free.row(j * samples + i) = initial.row(j) / noise[j];
      if (i + 1 == samples) break;
      const double h = m.time[k + 1] - m.time[k];
      JointVector q = motion_of.position.row(row), v = motion_of.velocity.row(row);
      const JointVector u = input_at(m, k, 0.5);
      JointVector qm = q + 0.5 * h * v, vm = 0.5 * (v + JointVector(motion_of.velocity.row(row + 1)));
      Eigen::MatrixXd rate = Eigen::MatrixXd::Zero(states, states);
      rate.block(0, n, n, n).setIdentity();
      for (Eigen::Index c = 0; c < states; ++c) {
        JointVector q1 = qm, v1 = vm, q2 = qm, v2 = vm;
        (c < n ? q1[c] : v1[c - n]) += kStep;
        (c < n ? q2[c] : v2[c - n]) -= kStep;
        rate.block(n, c, n, 1) = (motion(plant, q1, v1, u, m.time[k] + 0.5 * h).acceleration -
                                  motion(plant, q2, v2, u, m.time[k] + 0.5 * h).acceleration) /
                                 (2.0 * kStep);
      }
      const Eigen::MatrixXd square = rate * rate, one = Eigen::MatrixXd::Identity(states, states);
      const auto slot = static_cast<std::size_t>(i);
      phi[slot] = one + h * rate + 0.5 * h * h * square + h * h * h / 6.0 * (square * rate);
      gamma[slot] = (h * one + 0.5 * h * h * rate + h * h * h / 6.0 * square).rightCols(n);
      propagate(plant, q, v, m, k, JointVector::Zero(n));
      Eigen::VectorXd defect(states);
      defect << motion_of.position.row(row + 1).transpose() - q, motion_of.velocity.row(row + 1).transpose() - v;
      state = (phi[slot] * state - defect).eval();
      initial = (phi[slot] * initial).eval();
    }

    // Slow modes of every joint, then what the initial state cannot do.
    Eigen::MatrixXd slow = Eigen::MatrixXd::Zero(count * n, samples * n);
    for (Eigen::Index j = 0; j < n; ++j) {
      slow.block(j * count, j * samples, count, samples) = modes.transpose() / noise[j];
    }
    Eigen::MatrixXd start(count * n, states);
    for (Eigen::Index j = 0; j < n; ++j) {
      start.middleRows(j * count, count) = modes.transpose() * free.middleRows(j * samples, samples);
    }
    for (Eigen::Index c = 0; c < states; ++c) start.col(c).normalize();
    const Eigen::MatrixXd keep = orthonormal_complement(start).transpose();
    const Eigen::MatrixXd projection = keep * slow;
    Eigen::VectorXd flat(samples * n);
    for (Eigen::Index j = 0; j < n; ++j) flat.segment(j * samples, samples) = rest.col(j);
    targets.push_back(projection * flat);

    // Fast modes: what is left of each joint's residual beyond the slow ones.
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::VectorXd r = rest.col(j) / noise[j];
      fast[j] += r.squaredNorm() - (modes.transpose() * r).squaredNorm();
      fast_count[j] += static_cast<double>(samples - count);
    }

    // Adjoint: rows x states, from the end of the window back.
    const Eigen::Index rows = projection.rows();
    Eigen::MatrixXd adjoint = Eigen::MatrixXd::Zero(rows, states), map(rows, (samples - 1) * n);
    for (Eigen::Index i = samples - 1; i > 0; --i) {
      for (Eigen::Index j = 0; j < n; ++j) adjoint.col(j) += projection.col(j * samples + i);
      const auto slot = static_cast<std::size_t>(i - 1);
      map.middleCols((i - 1) * n, n).noalias() = adjoint * gamma[slot];
      adjoint = (adjoint * phi[slot]).eval();
    }
    map_.push_back(std::move(map));
    Eigen::VectorXd steps(samples - 1);
    for (Eigen::Index i = 0; i < steps.size(); ++i) {
      const std::size_t k = window.first + static_cast<std::size_t>(i);
      steps[i] = m.time[k + 1] - m.time[k];
    }
    steps_.push_back(std::move(steps));
    Eigen::MatrixXd interleaved(rows, samples * n);
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < samples; ++i) interleaved.col(i * n + j) = projection.col(j * samples + i);
    }
    projection_.push_back(std::move(interleaved));
    const Eigen::VectorXd size = free.colwise().norm();
    const Eigen::MatrixXd scaled = free * size.cwiseInverse().asDiagonal();
    const Eigen::MatrixXd inverse = solve_symmetric(scaled.transpose() * scaled, scaled.transpose());
    Eigen::MatrixXd start_map(states, samples * n), by_initial_state(samples * n, states);
    for (Eigen::Index j = 0; j < n; ++j) {
      for (Eigen::Index i = 0; i < samples; ++i) {
        by_initial_state.row(i * n + j) = free.row(j * samples + i) * noise[j];
        start_map.col(i * n + j) = size.cwiseInverse().cwiseProduct(inverse.col(j * samples + i)) / noise[j];
      }
    }
    start_.push_back(std::move(start_map));
    by_initial_state_.push_back(std::move(by_initial_state));
    offset_.push_back(rows_);
    rows_ += rows;
  }
  target_.resize(rows_);
  log_scale_.setZero(rows_);
  for (std::size_t w = 0; w < targets.size(); ++w) target_.segment(offset_[w], targets[w].size()) = targets[w];
  noise_ratio_ = (fast.array() / fast_count.array().max(1.0)).sqrt();
}

Eigen::MatrixXd LinearResponse::process_noise_covariance(std::size_t window, Eigen::Index joint) const {
  Eigen::MatrixXd columns(map_[window].rows(), steps_[window].size());
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    columns.col(i) = map_[window].col(i * joints_ + joint) / std::sqrt(steps_[window][i]);
  }
  return columns * columns.transpose();
}

LinearResponse LinearResponse::with_process_noise(const Eigen::VectorXd& intensity) const {
  LinearResponse result = *this;
  in_parallel(windows_.size(), [&](std::size_t w) {
    Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(map_[w].rows(), map_[w].rows());
    for (Eigen::Index j = 0; j < joints_; ++j)
      covariance += intensity[j] * intensity[j] * process_noise_covariance(w, j);
    const Cholesky root(covariance);
    result.log_scale_.segment(offset_[w], map_[w].rows()) += root.log_diagonal();
    result.map_[w] = root.whitened(map_[w]);
    result.projection_[w] = root.whitened(projection_[w]);
    result.target_.segment(offset_[w], map_[w].rows()) =
        root.whitened(target_.segment(offset_[w], map_[w].rows())).col(0);
  });
  return result;
}

Eigen::VectorXd LinearResponse::project(std::size_t window, const Eigen::MatrixXd& positions) const {
  return projection_[window] * positions.transpose().reshaped();
}

StateVector LinearResponse::initial_change(std::size_t window, const Eigen::MatrixXd& positions) const {
  return start_[window] * positions.transpose().reshaped();
}

Eigen::MatrixXd LinearResponse::initial_state_projected_out(std::size_t window,
                                                            const Eigen::MatrixXd& positions) const {
  const Eigen::VectorXd explained = by_initial_state_[window] * (start_[window] * positions.transpose().reshaped());
  return positions - explained.reshaped(positions.cols(), positions.rows()).transpose();
}

Eigen::MatrixXd LinearResponse::responses(const std::vector<Eigen::MatrixXd>& acceleration) const {
  Eigen::MatrixXd result(rows_, acceleration.front().cols());
  in_parallel(windows_.size(), [&](std::size_t w) {
    const auto first = static_cast<Eigen::Index>(windows_[w].first) * joints_;
    result.middleRows(offset_[w], map_[w].rows()).noalias() =
        map_[w] * acceleration[windows_[w].recording].middleRows(first, map_[w].cols());
  });
  return result;
}

Eigen::MatrixXd LinearResponse::measured(const std::vector<Eigen::MatrixXd>& positions) const {
  Eigen::MatrixXd result(rows_, positions.front().cols());
  in_parallel(windows_.size(), [&](std::size_t w) {
    const auto first = static_cast<Eigen::Index>(windows_[w].first) * joints_;
    result.middleRows(offset_[w], projection_[w].rows()).noalias() =
        projection_[w] * positions[windows_[w].recording].middleRows(first, projection_[w].cols());
  });
  return result;
}

}  // namespace bayesctrl
