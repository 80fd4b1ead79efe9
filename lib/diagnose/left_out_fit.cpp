#include "diagnose/left_out_fit.hpp"

#include "diagnose/remainder_search.hpp"

namespace bayesctrl {

LeftOutFit::LeftOutFit(const FitProblem& problem, const Fit& fit) : problem_(problem), fit_(fit) {
  slopes_ = linear_slopes(problem, fit_);
  for (Eigen::Index i = 0; i < slopes_.cols(); ++i) {
    const int effect = fit.unknowns[static_cast<std::size_t>(i)].effect;
    if (effect >= 0 && fit.effects[static_cast<std::size_t>(effect)].recording >= 0) slopes_.col(i).setZero();
  }
}

Fit LeftOutFit::without(int fold) const {
  if (fold < 0 || slopes_.cols() == 0) return fit_;
  // At the optimum all rows together ask for no step; without some of them the others ask for the opposite of theirs.
  const std::vector<int> folds = folds_of(problem_.response.windows());
  Eigen::MatrixXd curvature = information(slopes_, fit_);
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(slopes_.cols());
  for (std::size_t w = 0; w < folds.size(); ++w) {
    if (folds[w] != fold) continue;
    const Eigen::Index first = problem_.response.first_row(w), count = problem_.response.row_count(w);
    const auto own = slopes_.middleRows(first, count);
    curvature -= own.transpose() * own;
    slope -= own.transpose() * fit_.residual.segment(first, count);
  }
  Fit result = fit_;
  assign(result, values_of(fit_) + step_within_bounds(curvature, slope, fit_.unknowns));
  return result;
}

}  // namespace bayesctrl
