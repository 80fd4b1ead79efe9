#include "diagnose/discrepancy/left_out_fit.hpp"

#include "diagnose/discrepancy/left_out.hpp"
#include "diagnose/fit/linear_slopes.hpp"

namespace bayesctrl {

namespace {

/// Slopes of the rows by what may differ without a recording (rows x unknowns).
Eigen::MatrixXd shared_slopes(const FitProblem& problem, Fit& fit) {
  Eigen::MatrixXd slopes = linear_slopes(problem, fit);
  for (Eigen::Index i = 0; i < slopes.cols(); ++i) {
    const int effect = fit.unknowns[static_cast<std::size_t>(i)].effect;
    if (effect >= 0 && fit.effects[static_cast<std::size_t>(effect)].recording >= 0) slopes.col(i).setZero();
  }
  return slopes;
}

/// At the optimum all rows together ask for no step; without some of them the others ask for the opposite of theirs.
Eigen::VectorXd step_without(int fold, const std::vector<int>& folds, const FitProblem& problem, const Fit& fit,
                             const Eigen::MatrixXd& slopes) {
  Eigen::MatrixXd curvature = information(slopes, fit);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(slopes.cols());
  for (std::size_t w = 0; w < folds.size(); ++w) {
    if (folds[w] != fold) continue;
    const Eigen::Index first = problem.response.first_row(w), count = problem.response.row_count(w);
    const auto own = slopes.middleRows(first, count);
    curvature -= own.transpose() * own;
    slope -= own.transpose() * fit.residual.segment(first, count);
  }
  return step_within_bounds(curvature, slope, fit.unknowns);
}

}  // namespace

std::vector<Fit> left_out_fits(const FitProblem& problem, const Fit& fit, const std::vector<int>& folds) {
  std::vector<Fit> fits(static_cast<std::size_t>(kFolds), fit);
  if (fit.unknowns.empty()) return fits;
  Fit all = fit;
  const Eigen::MatrixXd slopes = shared_slopes(problem, all);
  for (int fold = 0; fold < kFolds; ++fold) {
    assign(fits[static_cast<std::size_t>(fold)], values_of(fit) + step_without(fold, folds, problem, all, slopes));
  }
  return fits;
}

}  // namespace bayesctrl
