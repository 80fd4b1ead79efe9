#include "diagnose/fit/runs.hpp"

#include <cmath>

#include "base/error.hpp"

namespace bayesctrl {

Runs::Runs(const FitProblem& problem, const Fit& fit)
    : problem_(problem),
      joints_(joints(fit.plant)),
      machines_(machines(fit.plant, fit.effects, problem.data)),
      shared_(bayesctrl::may_be_shared(fit.plant)) {
  const std::vector<Segment>& windows = problem.response.windows();
  std::vector<Restarts> plays(problem.data.size());
  for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
    const Segment& window = windows[w];
    if (!window.opens || !machines_[window.recording].has_plays()) continue;
    plays[window.recording].push_back({window.first, plays_of(fit.initial_states[w], joints_)});
  }
  std::vector<std::vector<Drive>> drives;
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    drives.push_back(drives_of(machines_[r], problem.data[r], plays[r]));
  }
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const std::size_t r = windows[w].recording;
    const Trajectory& path = problem.forcing.paths()[r];
    HiddenStates now =
        windows[w].opens ? machines_[r].hidden_at_rest()
                         : machines_[r].hidden_after(hidden_.back(), problem.data[r].time, path.position, path.velocity,
                                                     drives[r], windows[w - 1].first, windows[w].first);
    if (w < fit.initial_states.size()) now = hidden_states_of(fit.initial_states[w], std::move(now));
    hidden_.push_back(std::move(now));
  }
  drives_ = std::make_shared<const std::vector<std::vector<Drive>>>(std::move(drives));
}

Eigen::MatrixXd Runs::operator()(std::size_t w, const SegmentState& start, Eigen::MatrixXd* states) const {
  const Segment& window = problem_.response.windows()[w];
  const std::size_t r = window.recording;
  const std::vector<Drive> own = own_drives(machines_[r], problem_.data[r], window, start);
  return machines_[r].run(start.head(2 * joints_), problem_.data[r].time, own.empty() ? (*drives_)[r] : own,
                          window.first, window.last, problem_.max_step, hidden_states_of(start, hidden_[w]), states);
}

SegmentState Runs::precision(std::size_t w, const SegmentState& start) const {
  return precision_of(start, problem_.data[problem_.response.windows()[w].recording]);
}

SegmentState Runs::reach(std::size_t w, const SegmentState& start) const { return reach_of(start, machine(w)); }

Eigen::MatrixXd Runs::residual(std::size_t w, const SegmentState& start) const {
  const Segment& window = problem_.response.windows()[w];
  return problem_.data[window.recording].position.middleRows(static_cast<Eigen::Index>(window.first),
                                                             static_cast<Eigen::Index>(window.samples())) -
         (*this)(w, start);
}

void take(const FitProblem& problem, Fit& fit, std::size_t w, const Eigen::MatrixXd& residual) {
  fit.residual.segment(problem.response.first_row(w), problem.response.row_count(w)) =
      problem.response.project(w, residual);
}

void sum_up(Fit& fit) {
  fit.sse = fit.residual.squaredNorm();
  if (!std::isfinite(fit.sse)) throw NumericalError("the model diverges");
}

}  // namespace bayesctrl
