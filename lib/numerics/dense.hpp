#pragma once

#include <Eigen/LU>
#include <Eigen/QR>

#include "base/vector.hpp"

namespace bayesctrl {

/// Factorisations of matrices of any size, compiled once: each file that calls Eigen's own compiles them again, which
/// took a tenth of the time of a build.

/// L of A = L L', of a symmetric positive definite A of which the lower half alone is read.
class Cholesky {
 public:
  explicit Cholesky(const Eigen::MatrixXd& a);

  /// log det A.
  double log_determinant() const;
  /// log L_ii.
  Eigen::VectorXd log_diagonal() const;
  /// A^-1 b.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  /// L^-1 b: what has covariance A becomes white.
  Eigen::MatrixXd whitened(Eigen::MatrixXd b) const;
  /// b L'^-1.
  Eigen::MatrixXd whitened_on_the_right(Eigen::MatrixXd b) const;
  /// What is above the diagonal is 0.
  Eigen::MatrixXd lower() const;

 private:
  Eigen::MatrixXd factor_;  // what is above the diagonal means nothing
};

/// A^-1 b of a symmetric, nearly singular A (L D L' with pivots).
Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// D of the same.
Eigen::VectorXd symmetric_pivots(const Eigen::MatrixXd& a);

/// Least squares by Q R with pivots.
class PivotedQr {
 public:
  PivotedQr() = default;
  explicit PivotedQr(const Eigen::MatrixXd& a);
  /// x that makes |a x - b| least.
  Eigen::MatrixXd solve(const Eigen::MatrixXd& b) const;
  /// Orthonormal columns: a basis of those of a matrix of full rank.
  Eigen::MatrixXd basis() const;

 private:
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr_;
};

/// Orthonormal columns that span those of `a` (rows x columns, rows >= columns).
Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& a);

/// Orthonormal columns that span those of `a`, whatever their units, of which there may be none (Q R with pivots).
Eigen::MatrixXd scaled_basis(Eigen::MatrixXd a);

/// Orthonormal columns that span what those of `a` do not (rows x (rows - columns)).
Eigen::MatrixXd orthonormal_complement(const Eigen::MatrixXd& a);

/// a'a, of which the lower half alone is set; what is above the diagonal is 0.
Eigen::MatrixXd lower_gram(const Eigen::MatrixXd& a);

/// sum += scale a a', the lower half alone.
void add_outer_product(Eigen::MatrixXd& sum, const Eigen::MatrixXd& a, double scale);

/// a^-1 b of the small matrices of a machine's joints (L U with pivots); allocates nothing.
class JointSolver {
 public:
  explicit JointSolver(const JointMatrix& a);
  JointVector solve(const JointVector& b) const;
  JointMatrix solve(const JointMatrix& b) const;

 private:
  Eigen::PartialPivLU<JointMatrix> lu_;
};

}  // namespace bayesctrl
