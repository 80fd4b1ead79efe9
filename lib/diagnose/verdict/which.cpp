#include "diagnose/verdict/which.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "base/error.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/fit/process_noise.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/inclusion.hpp"
#include "numerics/distributions.hpp"

namespace bayesctrl {

namespace {

/// The candidate with effects whose free runs are best for its size, of those whose own windows are.
std::size_t most_worthwhile(const Explanation& explanation, const std::function<double(const Fit&)>& beyond_noise) {
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t i = 0; i < explanation.candidates.size(); ++i) {
    const Fit& f = explanation.candidates[i].fit;
    if (!f.effects.empty()) ranked.emplace_back(cost(explanation.excess(f), f), i);
  }
  std::sort(ranked.begin(), ranked.end());
  ranked.resize(std::min(ranked.size(), std::size_t{kSettings.verdict.compared_sets}));
  for (auto& [worth, i] : ranked) {
    const Fit& f = explanation.candidates[i].fit;
    worth = cost(beyond_noise(f), f);
  }
  return std::min_element(ranked.begin(), ranked.end())->second;
}

/// Evidence of candidates beside process noise; probabilities and ranks among those of at most `numbers` unknowns.
/// What has many more can be no alternative. All but the first then have the parameters that the evidence is of; those
/// of the first are returned.
Fit rank_with_process_noise(Explanation& explanation, const FitProblem& measured, const ExplainOptions& options,
                            std::size_t numbers) {
  const LikelyIntensity likely(measured.response);
  struct Settled {
    Fit fit;
    Eigen::VectorXd log_likelihood;  // of each row
  };
  std::map<std::string, Settled> settled;
  const auto settle = [&](Candidate& candidate) {
    candidate.fit.log_evidence = -kInfinity;
    if (candidate.fit.unknowns.size() > numbers + std::size_t{kSettings.verdict.many_more}) return;
    const BesideNoise one = beside_likely_noise(measured, likely, candidate.fit);
    candidate.fit.log_evidence = one.fit.log_evidence;
    settled.emplace(key(one.fit.effects), Settled{one.fit, one.log_likelihood()});
  };
  std::vector<Candidate>& candidates = explanation.candidates;
  for (Candidate& candidate : candidates) settle(candidate);
  const auto as_simple = [&](const Candidate& candidate) { return candidate.fit.unknowns.size() <= numbers; };
  const auto more_probable = [&](const Candidate& a, const Candidate& b) {
    return std::pair(as_simple(a), a.fit.log_evidence) > std::pair(as_simple(b), b.fit.log_evidence);
  };
  const auto most_probable = [&] { return std::min_element(candidates.begin(), candidates.end(), more_probable); };
  // What cannot be told from the best is a candidate even where the search has not come by.
  for (const std::vector<Effect>& set : equivalents(most_probable()->fit.effects)) {
    if (explanation.find(set) != nullptr || !options.allow(set)) continue;
    try {
      candidates.push_back({fit(measured, set)});
      settle(candidates.back());
    } catch (const NumericalError&) {  // it cannot be simulated
    }
  }
  std::iter_swap(candidates.begin(), most_probable());
  const double highest = explanation.best().fit.log_evidence;
  const Settled& best = settled.at(key(explanation.best().fit.effects));
  for (std::size_t i = 1; i < candidates.size(); ++i) {
    Fit& fit = candidates[i].fit;
    const auto its = settled.find(key(fit.effects));
    if (its == settled.end() || fit.log_evidence == -kInfinity) continue;
    if (!fit.effects.empty()) {
      fit.plant = its->second.fit.plant;
      fit.effects = its->second.fit.effects;
      fit.unknowns = its->second.fit.unknowns;
      fit.covariance = its->second.fit.covariance;
    }
    if (fit.log_evidence > highest) continue;
    fit.log_evidence =
        highest - vuong_bounded(highest - fit.log_evidence, best.log_likelihood - its->second.log_likelihood);
  }
  std::sort(candidates.begin() + 1, candidates.end(), more_probable);
  double sum = 0.0;
  for (Candidate& candidate : explanation.candidates) {
    candidate.probability = as_simple(candidate) ? std::exp(candidate.fit.log_evidence - highest) : 0.0;
    sum += candidate.probability;
  }
  for (Candidate& candidate : explanation.candidates) candidate.probability /= sum;
  return best.fit;
}

}  // namespace

double vuong_bounded(double nats, const Eigen::VectorXd& more) {
  const auto count = static_cast<double>(more.size());
  if (more.size() < 2) return nats;
  const double scatter = std::sqrt((more.array() - more.mean()).square().sum() * count / (count - 1.0));
  if (!(scatter > 0.0)) return nats;
  const double wrong = student_t_tail(nats / scatter, count - 1.0);
  return wrong > 0.0 ? std::min(nats, std::log((1.0 - wrong) / wrong)) : nats;
}

std::vector<std::string> labels(const std::vector<Effect>& effects, int joints) {
  std::vector<std::string> list;
  for (const Effect& effect : effects) list.push_back(label(effect, joints));
  return list;
}

bool Equivalence::sure() const {
  return probability >= kSettings.verdict.likely &&
         std::ranges::all_of(inclusion, [](double p) { return p >= kSettings.verdict.confident; });
}

Equivalence find_equivalent(const Explanation& explanation, int joints) {
  Equivalence result;
  const Fit& best = explanation.best().fit;
  for (const Effect& effect : best.effects) result.classes.push_back({label(effect, joints)});
  std::vector<std::string> own = labels(best.effects, joints);
  for (const Candidate& candidate : explanation.candidates) {
    const Fit& fit = candidate.fit;
    if (fit.effects.size() != best.effects.size() ||
        std::abs(best.log_evidence - fit.log_evidence) > kSettings.verdict.inseparable) {
      continue;
    }
    std::vector<std::string> other = labels(fit.effects, joints), lost;
    for (const std::string& name : own) {
      const auto at = std::find(other.begin(), other.end(), name);
      if (at == other.end()) {
        lost.push_back(name);
      } else {
        other.erase(at);
      }
    }
    if (lost.size() != 1 || other.size() != 1) continue;
    for (std::vector<std::string>& names : result.classes) {
      if (names.front() == lost.front() && std::find(names.begin(), names.end(), other.front()) == names.end()) {
        names.push_back(other.front());
      }
    }
  }
  // More than a few names are none: what is less probable is left to the alternatives.
  for (std::vector<std::string>& names : result.classes) {
    names.resize(std::min(names.size(), std::size_t{kSettings.verdict.most_equivalents}));
    result.inclusion.push_back(inclusion_of_any(explanation, names, joints));
  }
  for (const Candidate& candidate : explanation.candidates) {
    if (candidate.fit.effects.size() != best.effects.size()) continue;
    std::vector<std::string> left = labels(candidate.fit.effects, joints);
    bool inside = true;
    for (const std::vector<std::string>& names : result.classes) {
      const auto at = std::find_if(left.begin(), left.end(), [&](const std::string& name) {
        return std::find(names.begin(), names.end(), name) != names.end();
      });
      if (at == left.end()) {
        inside = false;
        break;
      }
      left.erase(at);
    }
    if (!inside) continue;
    result.probability += candidate.probability;
    result.sets.push_back(&candidate);
  }
  return result;
}

std::size_t strongest(const Explanation& explanation) {
  const Fit& best = explanation.best().fit;
  std::size_t strongest = 0;
  double most = -kInfinity;
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const Candidate* others = explanation.find(without(best.effects, e));
    if (others == nullptr) continue;
    if (const double loss = best.log_evidence - others->fit.log_evidence; loss > most) {
      most = loss;
      strongest = e;
    }
  }
  return strongest;
}

double beyond_noise(double error, double noise) { return std::sqrt(std::max(0.0, error * error - noise * noise)); }

double error_beyond_noise(const Fit& fit, const Explanation& explanation, const std::vector<Measured>& data,
                          const std::vector<Trajectory>& paths, double horizon) {
  const double rms = free_runs({fit.plant, fit.effects, {}}, data, paths, horizon, false, explanation.max_step).rms;
  return beyond_noise(rms, explanation.noise_rms());
}

void prefer_simple(Explanation& explanation, const std::vector<Measured>& data, const ExplainOptions& options,
                   double horizon) {
  if (explanation.excess(explanation.best().fit) < kSettings.verdict.imperfect ||
      explanation.best().fit.effects.empty())
    return;
  const auto beyond_noise = [&](const Fit& fit) {
    return error_beyond_noise(fit, explanation, data, explanation.measured->paths, horizon);
  };
  const FitProblem measured = problem_about(*explanation.measured, explanation, data, options);
  const Fit& worthwhile = explanation.candidates[most_worthwhile(explanation, beyond_noise)].fit;
  const Fit settled = rank_with_process_noise(explanation, measured, options, worthwhile.unknowns.size());

  Fit& best = explanation.candidates.front().fit;
  const double before = beyond_noise(best), evidence = best.log_evidence;
  best.covariance = settled.covariance;
  try {
    const Fit there = started(problem_about(*explanation.linearisation, explanation, data, options), settled);
    if (beyond_noise(there) < kSettings.verdict.contradicted * before) best = there;
  } catch (const NumericalError&) {  // free runs diverge there
  }
  best.log_evidence = evidence;
}

}  // namespace bayesctrl
