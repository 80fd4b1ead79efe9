#include "diagnose/discrepancy/selection.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>

#include "diagnose/discrepancy/left_out_fit.hpp"
#include "diagnose/discrepancy/remainder_search.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/fit/process_noise.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Seconds of all windows.
double duration(const std::vector<Segment>& windows, const std::vector<Measured>& data) {
  double sum = 0.0;
  for (const Segment& window : windows) {
    const std::vector<double>& t = data[window.recording].time;
    sum += t[window.last] - t[window.first];
  }
  return sum;
}

Remainder none(int) { return {}; }

/// With what predicts left-out parts, products of causes included. Time can imitate what the state and the input do,
/// and the past all of them: they count where they leave but a small part of what those leave.
Discrepancy::Dependence judged(Discrepancy::Dependence on, const Shares& predicted) {
  double before = 0.0;
  for (std::size_t i = 0; i < predicted.size(); ++i) {
    const bool imitates = static_cast<Cause>(i) >= Cause::time;
    const bool needed = before < kSettings.discrepancy.imitates_all &&
                        1.0 - predicted[i] <= kSettings.discrepancy.no_imitation * (1.0 - before);
    if (!imitates || needed) on.explained[i] = std::max(on.explained[i], predicted[i]);
    before = std::max(before, predicted[i]);
  }
  return on;
}

double penalty(const RemainderSearch::Basis& basis) {
  return kSettings.discrepancy.per_group * static_cast<double>(std::max<std::size_t>(basis.groups.size(), 1) - 1) +
         (basis.parametric ? 0.0 : kSettings.discrepancy.many_terms);
}

/// Keeps what predicts windows best that were left out. What is worse than the worst window of the first model counts
/// as that: a remainder that goes astray where it has learnt nothing is not judged by how far.
class Choice {
 public:
  Choice(const Explanation& explanation, std::vector<int> folds, const std::vector<Measured>& data,
         const std::vector<Trajectory>& motion, double horizon)
      : explanation_(explanation), folds_(std::move(folds)), data_(data), motion_(motion), horizon_(horizon) {}

  /// Whether effects are carried by all recordings: with the parameters that the others give them, what is left out
  /// fits not much worse. Where free runs go astray one step of their response says nothing of those parameters, and
  /// beside process noise it does.
  bool is_carried(const Fit& fit) const {
    if (carry(fit, left_out_fits(about(*explanation_.linearisation), fit, folds_))) return true;
    return explanation_.excess(fit) > kSettings.verdict.imperfect && carry(fit, left_out_beside_noise(fit));
  }

  /// `remainder`: learnt without the windows of a fold, or from all (-1); `penalty` for what it consists of.
  void consider(const Fit& fit, const Discrepancy::Dependence& remaining, double penalty,
                const std::function<Remainder(int)>& remainder) {
    if (lowest_ < std::log(kSettings.discrepancy.enough * explanation_.noise_rms())) return;
    std::vector<double> errors;
    for (int fold = 0; fold < kSettings.discrepancy.folds; ++fold) {
      const std::vector<double> more = errors_in({fit.plant, fit.effects, remainder(fold)}, fold);
      errors.insert(errors.end(), more.begin(), more.end());
    }
    if (worst_ == 0.0) worst_ = *std::max_element(errors.begin(), errors.end());
    double squares = 0.0;
    for (const double error : errors) squares += std::pow(std::min(error, worst_), 2);
    const double cost = 0.5 * std::log(squares / static_cast<double>(errors.size())) +
                        kSettings.discrepancy.per_effects * double(!fit.effects.empty()) + penalty;
    if (!(cost < lowest_ - kSettings.discrepancy.worthwhile)) return;
    lowest_ = cost;
    best_ = {fit, remainder(-1), remaining, {}};
  }

  const std::vector<int>& folds() const { return folds_; }
  const SelectedDiscrepancy& best() const { return best_; }

 private:
  FitProblem about(const Linearisation& linearisation) const {
    return problem_about(linearisation, explanation_, data_, {});
  }

  std::vector<Fit> left_out_beside_noise(const Fit& fit) const {
    const FitProblem measured = about(*explanation_.measured);
    const auto [white, settled] = beside_likely_noise(measured, LikelyIntensity(measured.response), fit);
    std::vector<Fit> fits;
    for (const Fit& without : left_out_fits(beside(measured, white), settled, folds_)) {
      fits.push_back(fit);
      assign(fits.back(), values_of(fit) + values_of(without) - values_of(settled));
    }
    return fits;
  }

  /// `without`: a fit without each fold.
  bool carry(const Fit& fit, const std::vector<Fit>& without) const {
    const auto squares = [&](const Fit& f, int fold) {
      double sum = 0.0;
      for (const double error : errors_in({f.plant, f.effects, {}}, fold)) sum += error * error;
      return sum;
    };
    double with_all = 0.0, left_out = 0.0;
    for (int fold = 0; fold < kSettings.discrepancy.folds; ++fold) {
      with_all += squares(fit, fold);
      left_out += squares(without[static_cast<std::size_t>(fold)], fold);
    }
    return left_out < kSettings.discrepancy.carried * kSettings.discrepancy.carried * with_all;
  }

  /// Errors in free runs over the windows of one fold, RMS.
  std::vector<double> errors_in(const Corrected& model, int fold) const {
    const std::vector<Segment>& windows = explanation_.measured->response->windows();
    std::size_t seen = 0;
    const std::size_t every = 1 + static_cast<std::size_t>(duration(windows, data_) / horizon_) /
                                      std::size_t{kSettings.discrepancy.most_windows};
    const auto wanted = [&](const Segment& run) {
      if (seen++ % every != 0) return false;
      for (std::size_t w = 0; w < windows.size(); ++w) {
        if (windows[w].recording != run.recording || run.first < windows[w].first || run.first > windows[w].last)
          continue;
        return folds_[w] == fold;
      }
      return false;
    };
    const double step = std::max(explanation_.max_step, kSettings.discrepancy.coarse_step);
    return free_runs(model, data_, motion_, horizon_, false, step, wanted).window_rms;
  }

  const Explanation& explanation_;
  std::vector<int> folds_;  // of the windows
  const std::vector<Measured>& data_;
  const std::vector<Trajectory>& motion_;
  double horizon_;
  double worst_ = 0.0;
  double lowest_ = kInfinity;
  SelectedDiscrepancy best_;
};

}  // namespace

SelectedDiscrepancy select_discrepancy(const Explanation& explanation, const Discrepancy& discrepancy,
                                       const Discrepancy& about_best, const Eigen::VectorXd& target,
                                       const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
                                       double horizon) {
  const Fit& best = explanation.best().fit;
  const Fit& nominal = explanation.without_effects().fit;
  Discrepancy::Dependence whole = discrepancy.dependence(target), beside = about_best.dependence(best.residual);
  Choice choice(explanation, folds_of(*explanation.measured->response, target), data, motion, horizon);
  const bool with_effects = !best.effects.empty() && choice.is_carried(best);
  RemainderSearch in_place(discrepancy, target, whole, choice.folds());
  whole = judged(whole, in_place.predicted());
  choice.consider(nominal, whole, 0.0, none);
  if (with_effects) choice.consider(best, beside, 0.0, none);
  for (const RemainderSearch::Basis& basis : in_place.best()) {
    choice.consider(nominal, whole, penalty(basis), [&](int out) { return in_place.remainder(basis, out); });
  }
  if (with_effects) {
    RemainderSearch more(about_best, best.residual, beside, choice.folds());
    beside = judged(beside, more.predicted());
    for (const RemainderSearch::Basis& basis : more.best()) {
      choice.consider(best, beside, penalty(basis), [&](int out) { return more.remainder(basis, out); });
    }
  }
  SelectedDiscrepancy result = choice.best();
  result.whole = whole;
  return result;
}

SelectedDiscrepancy select_beside_best(const Explanation& explanation, const Discrepancy& about_best,
                                       const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
                                       double horizon) {
  const Fit& best = explanation.best().fit;
  const Discrepancy::Dependence beside = about_best.dependence(best.residual);
  Choice choice(explanation, folds_of(*explanation.linearisation->response, best.residual), data, motion, horizon);
  choice.consider(best, beside, 0.0, none);
  const RemainderSearch more(about_best, best.residual, beside, choice.folds());
  const RemainderSearch::Basis leading = more.leading();
  choice.consider(best, beside, penalty(leading), [&](int out) { return more.remainder(leading, out); });
  return choice.best();
}

}  // namespace bayesctrl
