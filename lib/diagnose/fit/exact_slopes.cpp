#include "diagnose/fit/exact_slopes.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/fit/runs.hpp"

namespace bayesctrl {

ExactSlopes::ExactSlopes(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& linear) : slopes_(linear) {
  const Runs here(problem, fit);
  const Eigen::VectorXd values = values_of(fit);
  std::vector<Runs> beside;
  std::vector<double> steps;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    const Unknown& unknown = fit.unknowns[static_cast<std::size_t>(i)];
    const double posterior = 1.0 / std::sqrt(std::max(linear.col(i).squaredNorm(), 1e-300));
    double step = std::min(unknown.step, 0.3 * posterior);
    if (values[i] + step > unknown.high) step = -step;
    Fit moved = fit;
    Eigen::VectorXd there = values;
    there[i] += step;
    assign(moved, there);
    beside.emplace_back(problem, moved);
    steps.push_back(step);
  }
  for (std::size_t w = 0; w < fit.starts.size(); ++w) {
    const WindowStart& start = fit.starts[w];
    const Eigen::MatrixXd rest = here.rest(w, start);
    const WindowStart& weight = weights_.emplace_back(weights_of(here.precision(w, start), rest));
    // Below the samples what is known of the start itself.
    Eigen::MatrixXd by_start = Eigen::MatrixXd::Zero(rest.size() + start.size(), start.size());
    Eigen::MatrixXd by_unknown = Eigen::MatrixXd::Zero(by_start.rows(), values.size());
    by_start.bottomRows(start.size()).diagonal() = weight.cwiseSqrt();
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      WindowStart moved = start;
      moved[i] += kStartStep;
      by_start.col(i).head(rest.size()) = ((rest - here.rest(w, moved)) / kStartStep).reshaped();
    }
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      by_unknown.col(i).head(rest.size()) = ((rest - beside[slot].rest(w, start)) / steps[slot]).reshaped();
    }
    const auto& solver = starts_.emplace_back(by_start);
    const Eigen::MatrixXd along = solver.solve(by_unknown);
    const Eigen::MatrixXd cleared = (by_unknown - by_start * along).topRows(rest.size());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      slopes_.col(i).segment(problem.response.first_row(w), problem.response.row_count(w)) =
          problem.response.project(w, cleared.col(i).reshaped(rest.rows(), rest.cols()));
    }
    along_.push_back(along);
  }
}

void ExactSlopes::follow(const FitProblem& problem, Fit& next, const Eigen::VectorXd& change) const {
  for (std::size_t w = 0; w < starts_.size(); ++w) next.starts[w] -= WindowStart(along_[w] * change);
  const Runs runs(problem, next);
  for (std::size_t w = 0; w < starts_.size(); ++w) {
    Eigen::MatrixXd rest = runs.rest(w, next.starts[w]);
    const WindowStart& start = next.starts[w];
    Eigen::VectorXd left(rest.size() + start.size());
    left << rest.reshaped(), -weights_[w].cwiseSqrt().cwiseProduct(start);
    const WindowStart better = start + WindowStart(starts_[w].solve(left));
    const Eigen::MatrixXd tried = runs.rest(w, better);
    if (tried.squaredNorm() + weights_[w].dot(better.cwiseAbs2()) < left.squaredNorm()) {
      next.starts[w] = better;
      rest = tried;
    }
    take(problem, next, w, rest);
  }
  sum_up(next);
}

}  // namespace bayesctrl
