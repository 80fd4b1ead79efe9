#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace bayesctrl::testing {

/// |value - expected| relative to |expected|, or to `scale` where that is larger.
inline double relative_error(double value, double expected, double scale = 0.0) {
  const double size = std::max(std::abs(expected), scale);
  return value == expected ? 0.0 : std::abs(value - expected) / size;
}

/// Largest entry of |a - b|; NaN entries count as infinitely far apart.
template <class A, class B>
double largest_difference(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return INFINITY;
  if (a.size() == 0) return 0.0;
  const Eigen::MatrixXd difference = a - b;  // allFinite() of a product compares two evaluations of it
  return difference.allFinite() ? difference.cwiseAbs().maxCoeff() : INFINITY;
}

/// Central difference of f at x, extrapolated once by Richardson: error O(step^4).
inline double derivative(auto&& f, double x, double step) {
  const auto central = [&](double h) { return (f(x + h) - f(x - h)) / (2.0 * h); };
  return (4.0 * central(0.5 * step) - central(step)) / 3.0;
}

}  // namespace bayesctrl::testing
