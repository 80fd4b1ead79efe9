#include "diagnose/fit/autoregression.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr Eigen::Index kOrder = 4, kSteps = 20;  // values that it looks back on; steps of a window

/// Positions of a joint every `step` seconds from the first sample of a stretch to its last, along straight lines.
Eigen::VectorXd at_steps(const Measured& measured, const Segment& stretch, Eigen::Index joint, double step) {
  const double begin = measured.time[stretch.first], end = measured.time[stretch.last];
  Eigen::VectorXd values(static_cast<Eigen::Index>((end - begin) / step + 1e-9) + 1);
  std::size_t k = stretch.first;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const double t = begin + step * static_cast<double>(i);
    while (k + 1 < stretch.last && measured.time[k + 1] < t) ++k;
    const auto row = static_cast<Eigen::Index>(k);
    const double part = (t - measured.time[k]) / (measured.time[k + 1] - measured.time[k]);
    values[i] = std::lerp(measured.position(row, joint), measured.position(row + 1, joint), part);
  }
  return values;
}

/// Weights of the last values, the newest first, and a constant: least squares.
Eigen::VectorXd fitted(const std::vector<Measured>& train, Eigen::Index joint, double step) {
  std::vector<Eigen::VectorXd> pieces;
  Eigen::Index rows = 0;
  for (std::size_t r = 0; r < train.size(); ++r) {
    for (const Segment& stretch : stretches(train[r], r)) {
      if (stretch.samples() < 2) continue;
      pieces.push_back(at_steps(train[r], stretch, joint, step));
      rows += std::max<Eigen::Index>(0, pieces.back().size() - kOrder);
    }
  }
  Eigen::MatrixXd past(rows, kOrder + 1);
  Eigen::VectorXd next(rows);
  Eigen::Index row = 0;
  for (const Eigen::VectorXd& piece : pieces) {
    for (Eigen::Index k = kOrder; k < piece.size(); ++k, ++row) {
      past.row(row) << piece.segment(k - kOrder, kOrder).reverse().transpose(), 1.0;
      next[row] = piece[k];
    }
  }
  if (rows == 0) return Eigen::VectorXd::Unit(kOrder + 1, 0);
  return past.completeOrthogonalDecomposition().solve(next);
}

}  // namespace

double autoregression_error(const std::vector<Measured>& train, const std::vector<Measured>& data, double horizon) {
  const double step = horizon / kSteps;
  double squares = 0.0, count = 0.0;
  for (Eigen::Index joint = 0; joint < data.front().position.cols(); ++joint) {
    const Eigen::VectorXd weights = fitted(train, joint, step);
    for (const Segment& window : windows(data, horizon)) {
      const Eigen::VectorXd measured = at_steps(data[window.recording], window, joint, step);
      Eigen::VectorXd known(kOrder + 1);
      Eigen::VectorXd said = measured;
      for (Eigen::Index k = kOrder; k < said.size(); ++k) {
        known << said.segment(k - kOrder, kOrder).reverse(), 1.0;
        said[k] = weights.dot(known);
      }
      const double wrong = (said - measured).squaredNorm();
      const double still = (measured.array() - measured.mean()).square().sum();
      squares += wrong < still ? wrong : still;
      count += static_cast<double>(std::max<Eigen::Index>(1, measured.size() - kOrder));
    }
  }
  return std::sqrt(squares / count);
}

}  // namespace bayesctrl
