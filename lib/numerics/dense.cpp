#include "numerics/dense.hpp"

#include <Eigen/Cholesky>

namespace bayesctrl {

Cholesky::Cholesky(const Eigen::MatrixXd& a) : factor_(a) { Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> in_place(factor_); }

double Cholesky::log_determinant() const { return 2.0 * log_diagonal().sum(); }

Eigen::VectorXd Cholesky::log_diagonal() const { return factor_.diagonal().array().log(); }

Eigen::MatrixXd Cholesky::solve(const Eigen::MatrixXd& b) const {
  Eigen::MatrixXd x = b;
  factor_.triangularView<Eigen::Lower>().solveInPlace(x);
  factor_.triangularView<Eigen::Lower>().adjoint().solveInPlace(x);
  return x;
}

Eigen::MatrixXd Cholesky::whitened(Eigen::MatrixXd b) const {
  factor_.triangularView<Eigen::Lower>().solveInPlace(b);
  return b;
}

Eigen::MatrixXd Cholesky::whitened_on_the_right(Eigen::MatrixXd b) const {
  factor_.triangularView<Eigen::Lower>().adjoint().solveInPlace<Eigen::OnTheRight>(b);
  return b;
}

Eigen::MatrixXd Cholesky::lower() const { return factor_.triangularView<Eigen::Lower>(); }

Eigen::MatrixXd solve_symmetric(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) { return a.ldlt().solve(b); }

Eigen::VectorXd symmetric_pivots(const Eigen::MatrixXd& a) { return a.ldlt().vectorD(); }

PivotedQr::PivotedQr(const Eigen::MatrixXd& a) : qr_(a) {}

Eigen::MatrixXd PivotedQr::solve(const Eigen::MatrixXd& b) const { return qr_.solve(b); }

Eigen::MatrixXd PivotedQr::basis() const {
  return qr_.householderQ() * Eigen::MatrixXd::Identity(qr_.rows(), qr_.cols());
}

Eigen::MatrixXd orthonormal_basis(const Eigen::MatrixXd& a) {
  return a.householderQr().householderQ() * Eigen::MatrixXd::Identity(a.rows(), a.cols());
}

Eigen::MatrixXd scaled_basis(Eigen::MatrixXd a) {
  if (a.cols() == 0) return a;
  for (Eigen::Index i = 0; i < a.cols(); ++i) a.col(i).normalize();
  return PivotedQr(a).basis();
}

Eigen::MatrixXd orthonormal_complement(const Eigen::MatrixXd& a) {
  const Eigen::MatrixXd whole = a.householderQr().householderQ();
  return whole.rightCols(a.rows() - a.cols());
}

Eigen::MatrixXd lower_gram(const Eigen::MatrixXd& a) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(a.cols(), a.cols());
  gram.selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  return gram;
}

void add_outer_product(Eigen::MatrixXd& sum, const Eigen::MatrixXd& a, double scale) {
  sum.selfadjointView<Eigen::Lower>().rankUpdate(a, scale);
}

JointSolver::JointSolver(const JointMatrix& a) : lu_(a) {}

JointVector JointSolver::solve(const JointVector& b) const { return lu_.solve(b); }

JointMatrix JointSolver::solve(const JointMatrix& b) const { return lu_.solve(b); }

}  // namespace bayesctrl
