#include "numerics/growing_cholesky.hpp"

#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

using Four = Eigen::Matrix<double, GrowingCholesky::kPanel, 1>;
using FourByFour = Eigen::Matrix<double, GrowingCholesky::kPanel, GrowingCholesky::kPanel>;

Eigen::Map<const Four> four(const double* at) { return Eigen::Map<const Four>(at); }

/// sum_j panel(:, j) v_j over the columns before the diagonal block; four sums hide the latency of the additions.
Four multiply(const double* panel, const double* v, int columns) {
  Four s0 = Four::Zero(), s1 = Four::Zero(), s2 = Four::Zero(), s3 = Four::Zero();
  for (int j = 0; j < columns; j += 4, panel += 16) {
    s0 += four(panel) * v[j];
    s1 += four(panel + 4) * v[j + 1];
    s2 += four(panel + 8) * v[j + 2];
    s3 += four(panel + 12) * v[j + 3];
  }
  return (s0 + s1) + (s2 + s3);
}

}  // namespace

void GrowingCholesky::reserve(int samples) { values_.reserve(offset((samples + kPanel - 1) / kPanel)); }

double GrowingCholesky::append(double* row, double diagonal) {
  solve_lower(row);
  double pivot = diagonal;
  for (int j = 0; j < size_; ++j) pivot -= row[j] * row[j];
  // Below this the subtraction has lost every digit: the sample repeats earlier ones and its noise does not tell them
  // apart. NaN fails the comparison as well.
  const double resolution = std::numeric_limits<double>::epsilon() * (size_ + 1) * diagonal;
  if (!(pivot > resolution) || !std::isfinite(pivot)) {
    throw NumericalError("the covariance matrix of " + std::to_string(size_ + 1) +
                         " samples is not positive definite (pivot " + format(pivot, 3) + " of variance " +
                         format(diagonal, 3) + "): samples repeat and the noise variance is too small");
  }
  const double root = std::sqrt(pivot);

  const int p = size_ / kPanel;
  const int r = size_ % kPanel;
  if (r == 0) {
    values_.resize(offset(p + 1), 0.0);
    panel(p).rightCols<kPanel>().setIdentity();
  }
  auto target = panel(p);
  for (int j = 0; j < kPanel * p; ++j) target(r, j) = row[j];
  // Row r of the inverse of the diagonal block: -(l_r . inverse of the rows above) / root, then 1 / root.
  auto inverse = target.rightCols<kPanel>();
  for (int c = 0; c < r; ++c) {
    double sum = 0.0;
    for (int k = c; k < r; ++k) sum += row[kPanel * p + k] * inverse(k, c);
    inverse(r, c) = -sum / root;
  }
  inverse(r, r) = 1.0 / root;

  ++size_;
  log_determinant_ += 2.0 * std::log(root);
  return root;
}

void GrowingCholesky::solve_lower(double* v) const {
  const double* panel = values_.data();
  const int padded = padded_size();
  for (int first = 0; first < padded; first += kPanel) {
    const Four rest = four(v + first) - multiply(panel, v, first);
    panel += kPanel * first;
    Eigen::Map<Four>(v + first).noalias() = Eigen::Map<const FourByFour>(panel) * rest;
    panel += kPanel * kPanel;
  }
}

void GrowingCholesky::solve_upper(double* v) const {
  for (int p = padded_size() / kPanel - 1; p >= 0; --p) {
    const auto rows = panel(p);
    const Four solved = rows.rightCols<kPanel>().transpose() * four(v + kPanel * p);
    Eigen::Map<Four>(v + kPanel * p) = solved;
    for (int j = 0; j < kPanel * p; ++j) v[j] -= rows.col(j).dot(solved);
  }
}

}  // namespace bayesctrl
