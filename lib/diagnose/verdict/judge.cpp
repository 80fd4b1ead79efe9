#include "diagnose/verdict/judge.hpp"

#include <algorithm>

#include "base/format.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Where the best set leaves something: whether it is declined, and what stands in.
void judge_remainder(Judgement& judgement, const Search& search, const Missing& missing) {
  const Explanation& explanation = search.explanation;
  const double horizon = search.spec.horizon;
  const auto error = [&](const Fit& fit) {
    return error_beyond_noise(fit, explanation, search.data, search.smoothed, horizon);
  };
  judgement.share = error(search.best()) / std::max(error(search.refit()), 1e-300);
  const bool named_something = !search.best().effects.empty();
  Discrepancy::Beside odds;
  if (named_something) {
    odds = missing.discrepancy().beside(missing.rows().columns, missing.rows().target, explanation.penalty);
  }
  const bool earned = named_something && odds.log_odds > kSettings.verdict.earned;
  const bool declined = !earned || judgement.share > kSettings.verdict.material;
  if (declined) judgement.verdict = Verdict::unknown;
  std::optional<Discrepancy> anew;
  if (explanation.linearisation != explanation.measured) anew.emplace(search.about(), search.data);
  const Discrepancy& about_best = anew ? *anew : missing.discrepancy();
  const SelectedDiscrepancy found =
      declined ? select_discrepancy(explanation, missing.discrepancy(), about_best, missing.rows().target, search.data,
                                    search.smoothed, horizon)
               : select_beside_best(explanation, about_best, search.data, search.smoothed, horizon);
  judgement.fit = found.fit;
  judgement.remainder = found.remainder;
  judgement.left = found.remaining;
  if (!declined) return;
  judgement.whole = found.whole;
  judgement.beside = std::move(odds.inclusion);
}

std::string amount(double error, const FitFigures& fit) { return format(error, 3) + " " + fit.unit; }

/// Why held-out recordings contradict what explains the others; empty where they do not. `noise`: of their sensor.
std::string refutation(const FitFigures& fit, double noise) {
  const FitErrors& errors = fit.held_out;
  if (!errors.after || *errors.after < kSettings.verdict.held_out * noise) return "";
  const auto share = [](const FitErrors& of, double floor) {
    return beyond_noise(*of.after, floor) / std::max(beyond_noise(*of.refit, floor), 1e-300);
  };
  if (share(errors, noise) < kSettings.verdict.held_out_share) return "";
  if (fit.train.after && share(errors, noise) < kSettings.verdict.held_out_more * share(fit.train, fit.noise_floor))
    return "";
  return "held-out recordings contradict what explains the others: there it errs by " + amount(*errors.after, fit) +
         ", the model without it by " + amount(*errors.refit, fit);
}

/// Why what explains the recordings says hardly more of them than no physics does; empty where it does.
std::string triviality(const FitFigures& fit, double motion) {
  const FitErrors& errors = fit.judged();
  if (!errors.after || !errors.without_physics) return "";
  const double enough = std::max(kSettings.verdict.adequate * fit.noise_floor, kSettings.verdict.little * motion);
  if (*errors.after < enough || *errors.after * kSettings.verdict.knows_better < *errors.without_physics) return "";
  return "what explains the recordings is hardly better than a curve that knows no physics: it errs by " +
         amount(*errors.after, fit) + ", " + format(*errors.after / fit.noise_floor, 3) +
         " times the noise, an autoregression of the positions alone by " + amount(*errors.without_physics, fit);
}

void doubt(double& p) { p = std::min(p, kSettings.verdict.unheld); }

/// An effect, listed or not, by its label.
void doubt(Diagnosis& diagnosis, const std::string& name) {
  for (ExplainedEffect& listed : diagnosis.explanation.effects) {
    if (label(listed, diagnosis.joints) == name && listed.inclusion) doubt(*listed.inclusion);
  }
  for (auto& [of, p] : diagnosis.inclusion.items) {
    if (of == name) doubt(p);
  }
}

}  // namespace

Missing missing_torque(const Search& search) {
  const Explanation& explanation = search.explanation;
  return {*explanation.measured, search.data,
          free_projected_out(*explanation.measured, explanation.start, search.data, search.options.free)};
}

const Discrepancy& Missing::discrepancy() const {
  if (!discrepancy_) discrepancy_.emplace(about_, data_);
  return *discrepancy_;
}

Judgement judge(const Search& search, const Missing& missing, double p_given) {
  const Explanation& explanation = search.explanation;
  Judgement result;
  const bool named_something = !search.best().effects.empty();
  result.verdict = named_something ? Verdict::named : Verdict::nothing_missing;
  result.fit = search.best();
  result.equivalence = find_equivalent(explanation, search.spec.joints());
  result.p_given = p_given;
  result.significant = explanation.p_value(search.best()) <
                       (named_something ? kSettings.verdict.significant : kSettings.verdict.nothing);
  if (result.significant) judge_remainder(result, search, missing);
  if (result.verdict == Verdict::named && !result.equivalence.sure()) result.verdict = Verdict::ambiguous;
  result.parameters_explain =
      result.verdict == Verdict::nothing_missing && p_given < kSettings.verdict.nothing && !search.options.free.empty();
  if (result.detected() && !result.whole) result.whole = missing.discrepancy().dependence(missing.rows().target);
  return result;
}

void hold_to_account(Diagnosis& diagnosis, double motion, double held_out_noise) {
  const bool stated = diagnosis.verdict == Verdict::named || diagnosis.verdict == Verdict::ambiguous;
  if (!stated && diagnosis.verdict != Verdict::unknown) return;
  const std::string refuted =
      stated ? refutation(diagnosis.fit, std::max(diagnosis.fit.noise_floor, held_out_noise)) : "";
  const std::string trivial = refuted.empty() ? triviality(diagnosis.fit, motion) : "";
  if (refuted.empty() && trivial.empty()) return;
  if (stated) {
    diagnosis.verdict = Verdict::unknown;
    diagnosis.reason = refuted + trivial;
  }
  const FitErrors& errors = diagnosis.fit.judged();
  if (refuted.empty() && *errors.after < *errors.without_physics) return;  // its effects are at least some of it
  for (ExplainedEffect& effect : diagnosis.explanation.effects) {
    if (effect.inclusion) doubt(*effect.inclusion);
  }
  for (auto& [name, p] : diagnosis.inclusion.items) doubt(p);
  doubt(diagnosis.explanation.probability);
}

void doubt_beside_remainder(Diagnosis& diagnosis) {
  if (diagnosis.verdict != Verdict::named || !diagnosis.remainder) return;
  std::string small;
  int count = 0;
  for (ExplainedEffect& effect : diagnosis.explanation.effects) {
    if (!effect.share || *effect.share >= kSettings.verdict.above_remainder * diagnosis.remainder->share) continue;
    doubt(diagnosis, label(effect, diagnosis.joints));
    small += (count++ == 0 ? "" : ", ") + label(effect, diagnosis.joints);
  }
  if (count == 0) return;
  diagnosis.verdict = Verdict::unknown;
  doubt(diagnosis.explanation.probability);
  diagnosis.reason = small + (count == 1 ? " takes" : " each take") +
                     " away little more than is left unexplained, and may be a part of that";
}

void doubt_beside_discrepancy(Diagnosis& diagnosis, const std::map<std::string, double>& inclusion) {
  if (diagnosis.verdict != Verdict::unknown || !diagnosis.remainder) return;
  const double left = diagnosis.remainder->share;
  for (const ExplainedEffect& effect : diagnosis.explanation.effects) {
    const auto beside = inclusion.find(label(effect, kMaxJoints));
    const bool certain = beside != inclusion.end() && beside->second >= kSettings.verdict.confident;
    const bool imitates = left > kSettings.verdict.imitable && !certain;
    const bool small = effect.share && *effect.share < kSettings.verdict.part_of_remainder * left;
    if (imitates || small) doubt(diagnosis, label(effect, diagnosis.joints));
  }
}

void doubt_in_time(Diagnosis& diagnosis, const std::vector<Effect>& unconfirmed) {
  for (const Effect& effect : unconfirmed) doubt(diagnosis, label(effect, diagnosis.joints));
  if (unconfirmed.empty() || diagnosis.verdict != Verdict::named) return;
  diagnosis.verdict = Verdict::ambiguous;
  doubt(diagnosis.explanation.probability);
  diagnosis.reason = label(unconfirmed.front(), diagnosis.joints) +
                     " depends on time alone: it neither shows in two recordings nor makes what was held out better";
}

}  // namespace bayesctrl
