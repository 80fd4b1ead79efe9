#include "diagnose/fit/exact_jacobian.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/fit/runs.hpp"

namespace bayesctrl {

ExactJacobian::ExactJacobian(const FitProblem& problem, const Fit& fit, const Eigen::MatrixXd& linear)
    : jacobian_(linear) {
  const Eigen::VectorXd values = values_of(fit);
  std::vector<Runs> runs;  // here, and beside it by each unknown
  runs.reserve(fit.unknowns.size() + 1);
  runs.emplace_back(problem, fit);
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
    runs.emplace_back(problem, moved);
    steps.push_back(step);
  }
  const std::size_t windows = fit.initial_states.size();
  by_initial_state_.resize(windows);
  weights_.resize(windows);
  along_.resize(windows);
  each_window(runs, windows, [&](const std::vector<Runs>& own, std::size_t w) {
    const Runs& here = own.front();
    const SegmentState& start = fit.initial_states[w];
    const Eigen::MatrixXd residual = here.residual(w, start);
    const SegmentState& weight = weights_[w] = weights_of(here.precision(w, start), residual);
    const SegmentState reach = here.reach(w, start);
    // Below the samples what is known of the start itself.
    Eigen::MatrixXd by_initial_state = Eigen::MatrixXd::Zero(residual.size() + start.size(), start.size());
    Eigen::MatrixXd by_unknown = Eigen::MatrixXd::Zero(by_initial_state.rows(), values.size());
    by_initial_state.bottomRows(start.size()).diagonal() = weight.cwiseSqrt();
    for (Eigen::Index i = 0; i < start.size(); ++i) {
      const double step = state_step(start, i, reach);
      SegmentState moved = start;
      moved[i] += step;
      by_initial_state.col(i).head(residual.size()) = ((residual - here.residual(w, moved)) / step).reshaped();
    }
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const auto slot = static_cast<std::size_t>(i);
      by_unknown.col(i).head(residual.size()) =
          ((residual - own[slot + 1].residual(w, start)) / steps[slot]).reshaped();
    }
    const PivotedQr& solver = by_initial_state_[w] = PivotedQr(by_initial_state);
    const Eigen::MatrixXd along = solver.solve(by_unknown);
    const Eigen::MatrixXd projected = (by_unknown - by_initial_state * along).topRows(residual.size());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      jacobian_.col(i).segment(problem.response.first_row(w), problem.response.row_count(w)) =
          problem.response.project(w, projected.col(i).reshaped(residual.rows(), residual.cols()));
    }
    along_[w] = along;
  });
}

void ExactJacobian::follow(const FitProblem& problem, Fit& next, const Eigen::VectorXd& change) const {
  for (std::size_t w = 0; w < by_initial_state_.size(); ++w) next.initial_states[w] -= SegmentState(along_[w] * change);
  each_window(Runs(problem, next), by_initial_state_.size(), [&](const Runs& runs, std::size_t w) {
    const SegmentState reach = runs.reach(w, next.initial_states[w]);
    const SegmentState start = next.initial_states[w] = within(next.initial_states[w], reach);
    Eigen::MatrixXd residual = runs.residual(w, start);
    Eigen::VectorXd left(residual.size() + start.size());
    left << residual.reshaped(), -weights_[w].cwiseSqrt().cwiseProduct(start);
    const SegmentState better = within(start + SegmentState(by_initial_state_[w].solve(left).col(0)), reach);
    const Eigen::MatrixXd tried = runs.residual(w, better);
    if (tried.squaredNorm() + weights_[w].dot(better.cwiseAbs2()) < left.squaredNorm()) {
      next.initial_states[w] = better;
      residual = tried;
    }
    take(problem, next, w, residual);
  });
  sum_up(next);
}

}  // namespace bayesctrl
