#include "diagnose/fit/shooting.hpp"

#include <atomic>
#include <cmath>

#include "base/error.hpp"
#include "diagnose/fit/runs.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

double sse_of(const FitProblem& problem, const Fit& fit, std::size_t w) {
  return fit.residual.segment(problem.response.first_row(w), problem.response.row_count(w)).squaredNorm();
}

/// The initial state of one segment and its residual by free runs, where that leaves less.
void improve(const FitProblem& problem, const Runs& runs, Fit& fit, std::size_t w, const SegmentState& from) {
  const SegmentRun found =
      fit_initial_state([&](const SegmentState& start) { return runs.residual(w, start); }, from,
                        kSettings.fit.segment_iterations, runs.precision(w, from), runs.reach(w, from));
  if (!(problem.response.project(w, found.residual).squaredNorm() < sse_of(problem, fit, w))) return;
  take(problem, fit, w, found.residual);
  fit.initial_states[w] = found.start;
}

}  // namespace

double noise_sse(Eigen::Index rows) {
  return static_cast<double>(rows) + kSettings.fit.noise_deviations * std::sqrt(2.0 * static_cast<double>(rows));
}

void simulate(const FitProblem& problem, Fit& fit, int rounds, double most) {
  const int n = joints(fit.plant);
  fit.residual.resize(problem.response.rows());
  const double too_much = most * (1.0 + 1e-9);  // in whatever order the segments are summed up
  std::atomic<double> sum = 0.0;
  each_window(Runs(problem, fit), fit.initial_states.size(), [&](const Runs& runs, std::size_t w) {
    if (sum > too_much) return;
    SegmentState& start = fit.initial_states[w];
    Eigen::MatrixXd residual = runs.residual(w, start);
    for (int round = 0; round < rounds; ++round) {
      SegmentState moved = start;
      moved.head(2 * n) += problem.response.initial_change(w, residual);
      try {
        const Eigen::MatrixXd there = runs.residual(w, moved);
        if (!(there.squaredNorm() < residual.squaredNorm())) break;
        residual = there;
        start = moved;
      } catch (const NumericalError&) {  // diverges from there
        break;
      }
    }
    take(problem, fit, w, residual);
    sum += sse_of(problem, fit, w);
  });
  if (!(sum > too_much)) sum_up(fit);
  if (sum > too_much || fit.sse > most) throw NumericalError("the segments leave more than was asked for");
}

void polish(const FitProblem& problem, Fit& fit) {
  each_window(Runs(problem, fit), fit.initial_states.size(), [&](const Runs& runs, std::size_t w) {
    const bool simple = fit.initial_states[w].size() == 2 * joints(fit.plant);
    if (simple && sse_of(problem, fit, w) <= noise_sse(problem.response.row_count(w))) return;
    improve(problem, runs, fit, w, fit.initial_states[w]);
  });
  sum_up(fit);
}

bool recover(const FitProblem& problem, Fit& fit) {
  const std::vector<Segment>& windows = problem.response.windows();
  std::vector<std::size_t> astray;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (sse_of(problem, fit, w) > kSettings.fit.astray * noise_sse(problem.response.row_count(w))) astray.push_back(w);
  }
  if (astray.empty() || std::size_t{kSettings.fit.one_astray_of} * astray.size() > windows.size()) return false;
  const std::vector<Machine> list = machines(fit.plant, fit.effects, problem.data);
  const Eigen::Index states = 2 * joints(fit.plant);
  const double before = fit.sse;
  each_window(Runs(problem, fit), astray.size(), [&](const Runs& runs, std::size_t i) {
    const std::size_t w = astray[i];
    SegmentState anew = fit.initial_states[w];
    const std::size_t r = windows[w].recording;
    anew.head(states) = initial_guess(windows[w], problem.forcing.paths()[r], list[r]).head(states);
    for (const SegmentState& from : {SegmentState(fit.initial_states[w]), anew}) {
      try {
        improve(problem, runs, fit, w, from);
      } catch (const NumericalError&) {  // diverges from there
      }
    }
  });
  sum_up(fit);
  return fit.sse < kSettings.fit.recovered * before;
}

}  // namespace bayesctrl
