#include "diagnose/decline.hpp"

#include <cmath>

#include "diagnose/free_runs.hpp"

namespace bayesctrl {

namespace {

constexpr double kWorthwhile = 0.98;  // of the error: by less a larger model is not worth while

/// Squares of the error in free runs over windows of one fold.
double error_in(const Corrected& model, const Explanation& explanation, int fold, const std::vector<Measured>& data,
                const std::vector<Trajectory>& motion, double horizon) {
  const std::vector<Segment>& windows = explanation.measured->response->windows();
  const std::vector<int> folds = folds_of(windows);
  const auto wanted = [&](const Segment& run) {
    for (std::size_t w = 0; w < windows.size(); ++w) {
      if (windows[w].recording != run.recording || run.first < windows[w].first || run.first > windows[w].last)
        continue;
      return folds[w] == fold;
    }
    return false;
  };
  const FreeRuns runs = free_runs(model, data, motion, horizon, false, explanation.max_step, wanted);
  return runs.rms * runs.rms * runs.samples;
}

}  // namespace

StandIn stand_in(const Explanation& explanation, const Discrepancy& discrepancy, const Eigen::VectorXd& target,
                 const std::vector<Measured>& data, const std::vector<Trajectory>& motion, double horizon) {
  const Fit& best = explanation.best().fit;
  const Fit& nominal = explanation.without_effects().fit;
  const Discrepancy about_best(*explanation.linearisation, data);
  const Discrepancy::Dependence whole = discrepancy.dependence(target), beside = about_best.dependence(best.residual);
  StandIn result;
  double lowest = kInfinity;
  const auto consider = [&](const Fit& fit, const Discrepancy::Dependence& remaining, const auto& remainder) {
    double squares = 0.0;
    for (int fold = 0; fold < kFolds; ++fold) {
      squares += error_in({fit.plant, fit.effects, remainder(fold)}, explanation, fold, data, motion, horizon);
    }
    if (!(std::sqrt(squares) < kWorthwhile * lowest)) return;
    lowest = std::sqrt(squares);
    result = {fit, remainder(-1), remaining};
  };
  const auto none = [](int) { return Remainder{}; };
  consider(nominal, whole, none);
  if (!best.effects.empty()) consider(best, beside, none);
  for (const bool leading_only : {true, false}) {
    consider(nominal, whole, [&](int fold) { return discrepancy.remainder(target, whole, leading_only, fold); });
    if (best.effects.empty()) continue;
    consider(best, beside, [&](int fold) { return about_best.remainder(best.residual, beside, leading_only, fold); });
  }
  return result;
}

}  // namespace bayesctrl
