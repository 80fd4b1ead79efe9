#pragma once

#include <Eigen/Core>
#include <vector>

namespace bayesctrl {

/// Lower Cholesky factor L of a covariance matrix K = L L^T that grows by one sample at a time, O(n^2) each.
///
/// Storage: panels of four rows. Panel p holds rows 4p .. 4p+3 column after column (four contiguous numbers per
/// column), so that a solve streams through memory once and needs no horizontal sums, and a new row touches one panel
/// only. The 4 x 4 block on the diagonal holds the inverse of L's block. Rows that are not there yet are rows of the
/// identity; vectors are padded with zeros to `padded_size()`.
class GrowingCholesky {
 public:
  static constexpr int kPanel = 4;

  int size() const { return size_; }

  /// `size()` rounded up to whole panels: the length of every vector below.
  int padded_size() const { return (size_ + kPanel - 1) / kPanel * kPanel; }

  void reserve(int samples);

  /// Appends the row and column of a new sample. On entry `row` holds its covariances with the earlier samples (padded,
  /// room for one panel more), on return the new row of L without its diagonal. `diagonal` is its own variance.
  /// Returns the new diagonal element of L. Throws NumericalError if the matrix stops being positive definite.
  double append(double* row, double diagonal);

  /// v <- L^-1 v.
  void solve_lower(double* v) const;

  /// v <- L^-T v.
  void solve_upper(double* v) const;

  /// log det K.
  double log_determinant() const { return log_determinant_; }

 private:
  using Panel = Eigen::Matrix<double, kPanel, Eigen::Dynamic>;
  static std::size_t offset(int panel) { return std::size_t{8} * panel * (panel + 1); }
  Eigen::Map<const Panel> panel(int p) const { return {values_.data() + offset(p), kPanel, kPanel * (p + 1)}; }
  Eigen::Map<Panel> panel(int p) { return {values_.data() + offset(p), kPanel, kPanel * (p + 1)}; }

  int size_ = 0;
  double log_determinant_ = 0.0;
  std::vector<double> values_;
};

}  // namespace bayesctrl
