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
    odds = missing.discrepancy.beside(missing.rows.columns, missing.rows.target, explanation.penalty);
  }
  const bool earned = named_something && odds.log_odds > kSettings.verdict.earned;
  const bool declined = !earned || judgement.share > kSettings.verdict.material;
  if (declined) judgement.verdict = Verdict::unknown;
  std::optional<Discrepancy> anew;
  if (explanation.linearisation != explanation.measured) anew.emplace(search.about(), search.data);
  const Discrepancy& about_best = anew ? *anew : missing.discrepancy;
  const SelectedDiscrepancy found =
      declined ? select_discrepancy(explanation, missing.discrepancy, about_best, missing.rows.target, search.data,
                                    search.smoothed, horizon)
               : select_beside_best(explanation, about_best, search.data, search.smoothed, horizon);
  judgement.fit = found.fit;
  judgement.remainder = found.remainder;
  judgement.left = found.remaining;
  if (declined) judgement.whole = found.whole;
}

}  // namespace

Missing missing_torque(const Search& search) {
  const Explanation& explanation = search.explanation;
  return {Discrepancy(*explanation.measured, search.data),
          free_projected_out(*explanation.measured, explanation.start, search.data, search.options.free)};
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
  if (result.detected() && !result.whole) result.whole = missing.discrepancy.dependence(missing.rows.target);
  return result;
}

void hold_to_account(Diagnosis& diagnosis) {
  if (diagnosis.verdict != Verdict::named && diagnosis.verdict != Verdict::ambiguous) return;
  const FitErrors& errors = diagnosis.fit.held_out;
  const double noise = diagnosis.fit.noise_floor;
  if (!errors.after || *errors.after < kSettings.verdict.held_out * noise) return;
  const double share = beyond_noise(*errors.after, noise) / std::max(beyond_noise(*errors.refit, noise), 1e-300);
  if (share < kSettings.verdict.held_out_share) return;
  diagnosis.verdict = Verdict::unknown;
  const auto amount = [&](double error) { return format(error, 3) + " " + diagnosis.fit.unit; };
  diagnosis.reason = "held-out recordings contradict what explains the others: there it errs by " +
                     amount(*errors.after) + ", the model without it by " + amount(*errors.refit);
  const auto doubt = [](double& p) { p = std::min(p, kSettings.verdict.unheld); };
  for (ExplainedEffect& effect : diagnosis.explanation.effects) doubt(*effect.inclusion);
  for (auto& [name, p] : diagnosis.inclusion.items) doubt(p);
  doubt(diagnosis.explanation.probability);
}

}  // namespace bayesctrl
