#include "diagnose/decline.hpp"

#include <cmath>
#include <functional>

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

/// Keeps what predicts windows best that were left out.
class Choice {
 public:
  Choice(const Explanation& explanation, const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
         double horizon)
      : explanation_(explanation), data_(data), motion_(motion), horizon_(horizon) {}

  /// `remainder`: learnt without the windows of a fold, or from all (-1).
  void consider(const Fit& fit, const Discrepancy::Dependence& remaining,
                const std::function<Remainder(int)>& remainder) {
    double squares = 0.0;
    for (int fold = 0; fold < kFolds; ++fold) {
      squares += error_in({fit.plant, fit.effects, remainder(fold)}, explanation_, fold, data_, motion_, horizon_);
    }
    if (!(std::sqrt(squares) < kWorthwhile * lowest_)) return;
    lowest_ = std::sqrt(squares);
    best_ = {fit, remainder(-1), remaining};
  }

  const StandIn& best() const { return best_; }

 private:
  const Explanation& explanation_;
  const std::vector<Measured>& data_;
  const std::vector<Trajectory>& motion_;
  double horizon_;
  double lowest_ = kInfinity;
  StandIn best_;
};

Remainder none(int) { return {}; }

}  // namespace

StandIn stand_in(const Explanation& explanation, const Discrepancy& discrepancy, const Eigen::VectorXd& target,
                 const std::vector<Measured>& data, const std::vector<Trajectory>& motion, double horizon) {
  const Fit& best = explanation.best().fit;
  const Fit& nominal = explanation.without_effects().fit;
  const Discrepancy about_best(*explanation.linearisation, data);
  const Discrepancy::Dependence whole = discrepancy.dependence(target), beside = about_best.dependence(best.residual);
  Choice choice(explanation, data, motion, horizon);
  choice.consider(nominal, whole, none);
  if (!best.effects.empty()) choice.consider(best, beside, none);
  for (const bool leading_only : {true, false}) {
    choice.consider(nominal, whole, [&](int out) { return discrepancy.remainder(target, whole, leading_only, out); });
    if (best.effects.empty()) continue;
    choice.consider(best, beside,
                    [&](int out) { return about_best.remainder(best.residual, beside, leading_only, out); });
  }
  return choice.best();
}

StandIn beside_best(const Explanation& explanation, const std::vector<Measured>& data,
                    const std::vector<Trajectory>& motion, double horizon) {
  const Fit& best = explanation.best().fit;
  const Discrepancy about_best(*explanation.linearisation, data);
  const Discrepancy::Dependence beside = about_best.dependence(best.residual);
  Choice choice(explanation, data, motion, horizon);
  choice.consider(best, beside, none);
  choice.consider(best, beside, [&](int out) { return about_best.remainder(best.residual, beside, true, out); });
  return choice.best();
}

}  // namespace bayesctrl
