#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "gp/sparse.hpp"
#include "support/dense_gp.hpp"

namespace bayesctrl::testing {

/// The plain twin of SparsePosterior, by the same rules: mean and covariance of u, the function at the basis with its
/// jitter, by the formulas for conditional normal distributions in long double, every inverse computed anew.
class DenseSparsePosterior {
 public:
  DenseSparsePosterior(const Kernel& kernel, int most) : kernel_(kernel), variance_(variance(kernel)), most_(most) {}

  /// What has joined the basis, and what has left it for something less known.
  int joined() const { return joined_; }
  int left() const { return left_; }
  const std::vector<Eigen::VectorXd>& basis() const { return basis_; }

  void absorb(const Eigen::VectorXd& x, double y, double noise_variance) {
    const auto resolution = SparsePosterior::kResolution * variance_;
    const auto open =
        std::min<Number>(SparsePosterior::kNoiseShare * noise_variance, SparsePosterior::kUnknown * variance_);
    if (open_at(x) > std::max<Number>(open, resolution)) {
      if (size() == most_) {
        Eigen::Index known = 0;
        if (open_at(x) * inverse_.diagonal().maxCoeff(&known) > SparsePosterior::kWorthAPlace) {
          leave(known);
        } else if (open_at(x) > SparsePosterior::kUnknown * variance_) {
          leave(std::min_element(used_.begin(), used_.end()) - used_.begin());
        }
      }
      if (size() < most_) join(x);
    }
    Eigen::Index nearest = 0;
    covariances(x).maxCoeff(&nearest);
    used_[static_cast<std::size_t>(nearest)] = ++absorbed_;
    const Vector c = coefficients(x), along = covariance_ * c;
    const Number spread = c.dot(along), noise = std::max<Number>(noise_variance + open_at(x), resolution);
    mean_ += along * ((y - c.dot(mean_)) / (spread + noise));
    covariance_ -= (along * along.transpose() / (spread + noise)).eval();
  }

  Marginal predict(const Eigen::VectorXd& x) const {
    const Vector c = coefficients(x);
    return {static_cast<double>(c.dot(mean_)), static_cast<double>(c.dot(covariance_ * c) + open_at(x))};
  }

 private:
  using Number = long double;
  using Matrix = Eigen::Matrix<Number, Eigen::Dynamic, Eigen::Dynamic>;
  using Vector = Eigen::Matrix<Number, Eigen::Dynamic, 1>;

  Eigen::Index size() const { return static_cast<Eigen::Index>(basis_.size()); }

  Vector covariances(const Eigen::VectorXd& x) const {
    Vector k(size());
    for (Eigen::Index i = 0; i < size(); ++i) k[i] = covariance(kernel_, basis_[static_cast<std::size_t>(i)], x);
    return k;
  }
  /// E f(x) = c . u.
  Vector coefficients(const Eigen::VectorXd& x) const { return inverse_ * covariances(x); }
  Number open_at(const Eigen::VectorXd& x) const { return variance_ - covariances(x).dot(coefficients(x)); }

  void invert() {
    Matrix k(size(), size());
    for (Eigen::Index i = 0; i < size(); ++i) k.col(i) = covariances(basis_[static_cast<std::size_t>(i)]);
    k.diagonal().array() += SparsePosterior::kJitter * variance_;
    inverse_ = k.inverse();
  }

  void join(const Eigen::VectorXd& x) {
    const Vector c = coefficients(x), along = covariance_ * c;
    const Number open = open_at(x), own = c.dot(along) + open + SparsePosterior::kJitter * variance_;
    const Eigen::Index m = size();
    mean_.conservativeResize(m + 1);
    mean_[m] = c.dot(mean_.head(m));
    covariance_.conservativeResize(m + 1, m + 1);
    covariance_.col(m).head(m) = along;
    covariance_.row(m).head(m) = along.transpose();
    covariance_(m, m) = own;
    basis_.push_back(x);
    used_.push_back(0);
    ++joined_;
    invert();
  }

  void leave(Eigen::Index i) {
    std::vector<Eigen::Index> rest;
    for (Eigen::Index k = 0; k < size(); ++k) {
      if (k != i) rest.push_back(k);
    }
    mean_ = mean_(rest).eval();
    covariance_ = covariance_(rest, rest).eval();
    basis_.erase(basis_.begin() + i);
    used_.erase(used_.begin() + i);
    ++left_;
    invert();
  }

  Kernel kernel_;
  Number variance_ = 0.0;
  int most_ = 0, joined_ = 0, left_ = 0;
  std::vector<Eigen::VectorXd> basis_;
  std::vector<long> used_;  // the last sample that an input was nearest to
  long absorbed_ = 0;
  Matrix covariance_, inverse_;
  Vector mean_;
};

}  // namespace bayesctrl::testing
