#include "diagnose/verdict/inclusion.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/which.hpp"
#include "physics/catalogue.hpp"

namespace bayesctrl {

namespace {

/// Dry friction that is no stronger at rest than its simpler law is that law.
bool same_at_rest(const EffectForm& form, const EffectForm& simpler) {
  if (!form.roles().dry_friction || !simpler.roles().dry_friction) return false;
  const JointState rest{.motor_torque = 1.0};  // under a load, where that counts
  const double level = simpler.sliding(rest);
  return std::abs(form.sliding(rest) - level) < kSettings.verdict.same_law * level;
}

/// The set in which such laws have given way; empty where there is none.
std::optional<std::size_t> collapsed(const Explanation& explanation, const Candidate& candidate) {
  std::vector<Effect> simpler = candidate.fit.effects;
  bool any = false;
  for (Effect& effect : simpler) {
    EffectForm form = effect.form;
    if (!simplify(form) || !same_at_rest(effect.form, form)) continue;
    effect.form = form;
    any = true;
  }
  const Candidate* to = any ? explanation.find(simpler) : nullptr;
  if (to == nullptr || to == &candidate) return std::nullopt;
  return static_cast<std::size_t>(to - explanation.candidates.data());
}

/// Whether a set is ahead of another by more than leaves both names open.
bool is_ahead(const Candidate& candidate, const Candidate& other) {
  return candidate.fit.log_evidence > other.fit.log_evidence + kSettings.verdict.inseparable;
}

/// The simpler set of which this one differs by an effect that never acts: the recordings say nothing about it, and
/// what it has is the prior's. Empty where there is none.
std::optional<std::size_t> idle(const Explanation& explanation, const Candidate& candidate) {
  for (std::size_t e = 0; e < candidate.fit.effects.size(); ++e) {
    const Candidate* fewer = explanation.find(without(candidate.fit.effects, e));
    if (fewer == nullptr || std::abs(fewer->fit.sse - candidate.fit.sse) > kSettings.verdict.never_acts) continue;
    const double lost = fewer->fit.log_evidence - candidate.fit.log_evidence - explanation.penalty;
    if (std::abs(lost) > kSettings.verdict.never_acts) continue;
    return static_cast<std::size_t>(fewer - explanation.candidates.data());
  }
  return std::nullopt;
}

/// The simpler set that does nearly as well as this one although the noise can tell the two apart (else their evidence
/// says which), the best of several; empty where there is none.
std::optional<std::size_t> as_good(const Explanation& explanation, const Candidate& candidate, double immaterial) {
  std::optional<std::size_t> best;
  for (const std::vector<Effect>& set : simpler_sets(candidate.fit.effects)) {
    const Candidate* simpler = explanation.find(set);
    if (simpler == nullptr || simpler == &candidate) continue;
    const double more = simpler->fit.sse - candidate.fit.sse;
    if (!(more > 2.0 * kSettings.verdict.inseparable && more < immaterial)) continue;
    const auto place = static_cast<std::size_t>(simpler - explanation.candidates.data());
    if (!best || simpler->fit.sse < explanation.candidates[*best].fit.sse) best = place;
  }
  return best;
}

double log_of_sum(double a, double b) {
  const double most = std::max(a, b);
  return most == -kInfinity ? most : most + std::log(std::exp(a - most) + std::exp(b - most));
}

}  // namespace

void merge_immaterial(Explanation& explanation) {
  const double nominal = explanation.without_effects().fit.sse;
  const double immaterial = std::pow(kSettings.verdict.immaterial, 2) * nominal;
  const double unseen = std::pow(kSettings.verdict.unseen, 2) * nominal;
  std::vector<Candidate>& list = explanation.candidates;
  std::vector<std::size_t> order(list.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  // The largest first, so that what a set was given it hands on.
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    return std::pair(list[a].fit.effects.size(), list[a].fit.unknowns.size()) >
           std::pair(list[b].fit.effects.size(), list[b].fit.unknowns.size());
  });
  for (const std::size_t i : order) {
    if (!(list[i].probability > 0.0)) continue;
    // A law that is ahead of what it has become is so by what its arithmetic gains at rest.
    std::optional<std::size_t> to = collapsed(explanation, list[i]);
    if (to && !is_ahead(list[i], list[*to])) to.reset();
    if (!to) to = idle(explanation, list[i]);
    const bool perfect = explanation.excess(list[i].fit) < kSettings.verdict.imperfect;
    if (!to) to = as_good(explanation, list[i], perfect ? unseen : immaterial);
    if (!to) continue;
    Candidate &from = list[i], &heir = list[*to];
    heir.probability += from.probability;
    heir.fit.log_evidence = log_of_sum(heir.fit.log_evidence, from.fit.log_evidence);
    from.probability = 0.0;
    from.fit.log_evidence = -kInfinity;
  }
  std::ranges::stable_sort(list, std::greater{}, &Candidate::probability);
  // Of two names that the recordings leave open the simpler comes first.
  if (const std::optional<std::size_t> to = collapsed(explanation, list.front()); to && !is_ahead(list[0], list[*to])) {
    std::rotate(list.begin(), list.begin() + static_cast<std::ptrdiff_t>(*to),
                list.begin() + static_cast<std::ptrdiff_t>(*to) + 1);
  }
}

std::map<std::string, double> inclusion(const Explanation& explanation) {
  std::map<std::string, double> sums;
  for (const Candidate& candidate : explanation.candidates) {
    for (const Effect& effect : candidate.fit.effects) {
      sums[label(effect, kMaxJoints)] += candidate.probability;
    }
  }
  return sums;
}

double inclusion_of_any(const Explanation& explanation, const std::vector<std::string>& names, int joints) {
  double sum = 0.0;
  for (const Candidate& candidate : explanation.candidates) {
    const bool holds = std::ranges::any_of(candidate.fit.effects, [&](const Effect& effect) {
      return std::ranges::find(names, label(effect, joints)) != names.end();
    });
    if (holds) sum += candidate.probability;
  }
  return sum;
}

std::vector<double> shares(const Explanation& explanation, const std::vector<Measured>& data,
                           const ExplainOptions& options, double horizon) {
  const Fit& best = explanation.best().fit;
  const auto squares = [&](const Fit& fit) {
    return std::pow(error_beyond_noise(fit, explanation, data, explanation.measured->paths, horizon), 2);
  };
  const FitProblem problem = problem_about(*explanation.linearisation, explanation, data, options);
  const double least = squares(best), all = squares(explanation.without_effects().fit) - least;
  std::vector<double> list;
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const std::vector<Effect> others = without(best.effects, e);
    double left = kInfinity;
    try {
      const Candidate* known = explanation.find(others);
      left = squares(known != nullptr && !known->fit.glanced ? known->fit : fit(problem, others));
    } catch (const NumericalError&) {  // nothing runs without it
    }
    list.push_back(all > 0.0 ? std::clamp((left - least) / all, 0.0, 1.0) : 0.0);
  }
  return list;
}

}  // namespace bayesctrl
