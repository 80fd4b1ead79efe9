#include "diagnose/runs.hpp"

#include <cmath>
#include <map>

#include "base/error.hpp"

namespace bayesctrl {

Runs::Runs(const FitProblem& problem, const Fit& fit)
    : problem_(problem), joints_(joints(fit.plant)), machines_(machines(fit.plant, fit.effects, problem.data.size())) {
  std::vector<std::map<std::size_t, JointVector>> known(problem.data.size());
  for (std::size_t w = 0; w < fit.starts.size(); ++w) {
    const Segment& window = problem.response.windows()[w];
    if (fit.starts[w].size() > 2 * joints_) known[window.recording][window.first] = fit.starts[w].tail(joints_);
  }
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    drives_.push_back(drives_of(machines_[r], problem.data[r]));
    const Eigen::MatrixXd& v = problem.excitation.paths()[r].velocity;
    hidden_.push_back(machines_[r].has_hidden_states() ? machines_[r].hidden_states(problem.data[r].time, v, known[r])
                                                       : Eigen::MatrixXd::Zero(v.rows(), v.cols()));
  }
}

Eigen::MatrixXd Runs::operator()(std::size_t w, const WindowStart& start, Eigen::MatrixXd* states) const {
  const Segment& window = problem_.response.windows()[w];
  const std::size_t r = window.recording;
  const bool free = start.size() > 2 * joints_;
  const JointVector hidden =
      free ? JointVector(start.tail(joints_)) : JointVector(hidden_[r].row(static_cast<Eigen::Index>(window.first)));
  return machines_[r].run(start.head(2 * joints_), problem_.data[r].time, drives_[r], window.first, window.last,
                          problem_.max_step, hidden, states);
}

Eigen::MatrixXd Runs::rest(std::size_t w, const WindowStart& start) const {
  const Segment& window = problem_.response.windows()[w];
  return problem_.data[window.recording].position.middleRows(static_cast<Eigen::Index>(window.first),
                                                             static_cast<Eigen::Index>(window.samples())) -
         (*this)(w, start);
}

void take(const FitProblem& problem, Fit& fit, std::size_t w, const Eigen::MatrixXd& rest) {
  fit.residual.segment(problem.response.first_row(w), problem.response.row_count(w)) =
      problem.response.project(w, rest);
}

void sum_up(Fit& fit) {
  fit.squares = fit.residual.squaredNorm();
  if (!std::isfinite(fit.squares)) throw NumericalError("the model diverges");
}

}  // namespace bayesctrl
