#include "diagnose/fit/starts.hpp"

#include <cmath>

#include "base/error.hpp"
#include "diagnose/fit/runs.hpp"

namespace bayesctrl {

namespace {

constexpr int kStartRounds = 8;   // of Levenberg-Marquardt
constexpr double kUnusual = 1.0;  // standard deviations of squares that noise alone explains
constexpr double kAstray = 3.0;   // times the usual squares, of a window that has gone astray,
constexpr std::size_t kFew = 3;   // at most one of so many windows

double squares_of(const FitProblem& problem, const Fit& fit, std::size_t w) {
  return fit.residual.segment(problem.response.first_row(w), problem.response.row_count(w)).squaredNorm();
}

/// The start of one window and its residual, with slopes from the machine itself, where that leaves less.
void improve(const FitProblem& problem, const Runs& runs, Fit& fit, std::size_t w, const WindowStart& from) {
  const WindowStart x = fit_start([&](const WindowStart& start) { return runs.rest(w, start); }, from, kStartRounds,
                                  runs.precision(w, from));
  const Eigen::MatrixXd rest = runs.rest(w, x);
  if (!(problem.response.project(w, rest).squaredNorm() < squares_of(problem, fit, w))) return;
  take(problem, fit, w, rest);
  fit.starts[w] = x;
}

}  // namespace

double usual_squares(Eigen::Index rows) {
  return static_cast<double>(rows) + kUnusual * std::sqrt(2.0 * static_cast<double>(rows));
}

void simulate(const FitProblem& problem, Fit& fit, int rounds) {
  const Runs runs(problem, fit);
  const int n = joints(fit.plant);
  fit.residual.resize(problem.response.rows());
  for (std::size_t w = 0; w < fit.starts.size(); ++w) {
    for (int round = 0; round < rounds; ++round) {
      fit.starts[w].head(2 * n) += problem.response.initial_change(w, runs.rest(w, fit.starts[w]));
    }
    take(problem, fit, w, runs.rest(w, fit.starts[w]));
  }
  sum_up(fit);
}

void polish(const FitProblem& problem, Fit& fit) {
  const Runs runs(problem, fit);
  for (std::size_t w = 0; w < fit.starts.size(); ++w) {
    const bool simple = fit.starts[w].size() == 2 * joints(fit.plant);
    if (simple && squares_of(problem, fit, w) <= usual_squares(problem.response.row_count(w))) continue;
    improve(problem, runs, fit, w, fit.starts[w]);
  }
  sum_up(fit);
}

bool recover(const FitProblem& problem, Fit& fit) {
  const std::vector<Segment>& windows = problem.response.windows();
  std::vector<std::size_t> astray;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (squares_of(problem, fit, w) > kAstray * usual_squares(problem.response.row_count(w))) astray.push_back(w);
  }
  if (astray.empty() || kFew * astray.size() > windows.size()) return false;
  const Runs runs(problem, fit);
  const std::vector<Machine> list = machines(fit.plant, fit.effects, problem.data.size());
  const Eigen::Index states = 2 * joints(fit.plant);
  const double before = fit.squares;
  for (const std::size_t w : astray) {
    WindowStart anew = fit.starts[w];
    const std::size_t r = windows[w].recording;
    anew.head(states) = first_start(windows[w], problem.excitation.paths()[r], list[r]).head(states);
    for (const WindowStart& from : {WindowStart(fit.starts[w]), anew}) {
      try {
        improve(problem, runs, fit, w, from);
      } catch (const NumericalError&) {  // diverges from there
      }
    }
  }
  sum_up(fit);
  return fit.squares < kMuch * before;
}

}  // namespace bayesctrl
