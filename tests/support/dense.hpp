#pragma once

#include <Eigen/Core>

/// Eigen's decompositions as tests need them for reference, compiled once for all tests.
namespace bayesctrl::testing::dense {

/// A^-1 b of a square A.
Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);
Eigen::MatrixXd inverse(const Eigen::MatrixXd& a);

/// x that makes |a x - b| least.
Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// What the columns of `a` can make of b.
Eigen::MatrixXd projected(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b);

/// L of A = L L'.
Eigen::MatrixXd lower_factor(const Eigen::MatrixXd& a);
double log_determinant(const Eigen::MatrixXd& a);

/// log N(y; 0, C) without its constant, (2 pi)^-n/2.
double log_density(const Eigen::VectorXd& y, const Eigen::MatrixXd& covariance);

/// Of a symmetric A: eigenvalues, ascending, and the symmetric root.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a);
Eigen::MatrixXd square_root(const Eigen::MatrixXd& a);

Eigen::MatrixXd exponential(const Eigen::MatrixXd& a);

}  // namespace bayesctrl::testing::dense
