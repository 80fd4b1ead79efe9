#include "diagnose/motion/likely_intensity.hpp"

#include <cmath>

#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"
#include "numerics/minimize.hpp"

namespace bayesctrl {

LikelyIntensity::LikelyIntensity(const LinearResponse& response) : response_(response) {
  for (std::size_t w = 0; w < response.windows().size(); ++w) {
    covariance_.emplace_back();
    for (Eigen::Index j = 0; j < response.joints(); ++j) {
      covariance_.back().push_back(response.process_noise_covariance(w, j));
      scale_ += covariance_.back().back().trace() / static_cast<double>(response.rows());
    }
  }
}

Eigen::VectorXd LikelyIntensity::operator()(const Eigen::VectorXd& residual) const {
  const Eigen::Index joints = response_.joints();
  // Minus the log likelihood of the logarithms of squared intensities.
  const auto cost = [&](const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    double sum = 0.0;
    gradient.setZero();
    for (std::size_t w = 0; w < covariance_.size(); ++w) {
      const std::vector<Eigen::MatrixXd>& parts = covariance_[w];
      const Eigen::Index rows = response_.row_count(w);
      Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(rows, rows);
      for (Eigen::Index j = 0; j < joints; ++j) covariance += std::exp(x[j]) * parts[static_cast<std::size_t>(j)];
      const Cholesky root(covariance);
      const Eigen::MatrixXd inverse = root.solve(Eigen::MatrixXd::Identity(rows, rows));
      const Eigen::VectorXd rest = residual.segment(response_.first_row(w), rows), solved = inverse * rest;
      sum += 0.5 * (rest.dot(solved) + root.log_determinant());
      for (Eigen::Index j = 0; j < joints; ++j) {
        const Eigen::MatrixXd& part = parts[static_cast<std::size_t>(j)];
        gradient[j] += 0.5 * std::exp(x[j]) * (inverse.cwiseProduct(part).sum() - solved.dot(part * solved));
      }
    }
    return sum;
  };
  // Sought about where noise and random acceleration weigh the same.
  const Eigen::VectorXd middle = Eigen::VectorXd::Constant(joints, std::log(std::max(scale_, 1e-300)));
  const double left = residual.squaredNorm() / static_cast<double>(response_.rows());
  const Eigen::VectorXd start = (std::log(std::max(left, 1e-300)) - middle.array()).matrix();
  const Eigen::VectorXd low = (-middle.array() - kSettings.motion.intensity_range).matrix(),
                        high = (-middle.array() + kSettings.motion.intensity_range).matrix();
  const MinimizeSummary found = minimize(cost, start, low, high, {.max_evaluations = 60, .relative_tolerance = 1e-6});
  return (0.5 * found.x.array()).exp().matrix();
}

}  // namespace bayesctrl
