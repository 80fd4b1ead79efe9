#include "diagnose/discrepancy/left_out_fit.hpp"

#include "diagnose/discrepancy/left_out.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Jacobian of the rows by what may differ without a recording (rows x unknowns).
Eigen::MatrixXd shared_jacobian(const FitProblem& problem, const Fit& fit) {
  Eigen::MatrixXd jacobian = linear_jacobian(problem, fit);
  for (Eigen::Index i = 0; i < jacobian.cols(); ++i) {
    const int effect = fit.unknowns[static_cast<std::size_t>(i)].effect;
    if (effect >= 0 && fit.effects[static_cast<std::size_t>(effect)].recording >= 0) jacobian.col(i).setZero();
  }
  return jacobian;
}

/// At the optimum all rows together ask for no step; without some of them the others ask for the opposite of theirs.
Eigen::VectorXd step_without(int fold, const std::vector<int>& folds, const FitProblem& problem, const Fit& fit,
                             const Eigen::MatrixXd& jacobian) {
  QuadraticModel model = quadratic_model(jacobian, fit);
  model.descent.setZero();
  for (std::size_t w = 0; w < folds.size(); ++w) {
    if (folds[w] != fold) continue;
    const Eigen::Index first = problem.response.first_row(w), count = problem.response.row_count(w);
    const auto own = jacobian.middleRows(first, count);
    model.hessian -= own.transpose() * own;
    model.descent -= own.transpose() * fit.residual.segment(first, count);
  }
  return bounded_step(model);
}

}  // namespace

std::vector<Fit> left_out_fits(const FitProblem& problem, const Fit& fit, const std::vector<int>& folds) {
  std::vector<Fit> fits(static_cast<std::size_t>(kSettings.discrepancy.folds), fit);
  if (fit.unknowns.empty()) return fits;
  const Eigen::MatrixXd jacobian = shared_jacobian(problem, fit);
  for (int fold = 0; fold < kSettings.discrepancy.folds; ++fold) {
    assign(fits[static_cast<std::size_t>(fold)], values_of(fit) + step_without(fold, folds, problem, fit, jacobian));
  }
  return fits;
}

}  // namespace bayesctrl
