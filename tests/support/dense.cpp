#include "support/dense.hpp"

#include <Eigen/Dense>
#include <unsupported/Eigen/MatrixFunctions>

namespace bayesctrl::testing::dense {

Eigen::MatrixXd solve(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.partialPivLu().solve(b); }

Eigen::MatrixXd inverse(const Eigen::MatrixXd& a) { return a.partialPivLu().inverse(); }

Eigen::MatrixXd least_squares(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.colPivHouseholderQr().solve(b);
}

Eigen::MatrixXd projected(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a * least_squares(a, b); }

Eigen::MatrixXd lower_factor(const Eigen::MatrixXd& a) { return a.llt().matrixL(); }

double log_determinant(const Eigen::MatrixXd& a) { return 2.0 * lower_factor(a).diagonal().array().log().sum(); }

double log_density(const Eigen::VectorXd& y, const Eigen::MatrixXd& covariance) {
  return -0.5 * (y.dot(solve(covariance, y).col(0)) + log_determinant(covariance));
}

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a, Eigen::EigenvaluesOnly).eigenvalues();
}

Eigen::MatrixXd square_root(const Eigen::MatrixXd& a) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(a).operatorSqrt();
}

Eigen::MatrixXd exponential(const Eigen::MatrixXd& a) { return a.exp(); }

}  // namespace bayesctrl::testing::dense
