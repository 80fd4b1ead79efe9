#include "control/tuning.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"

namespace bayesctrl {

TuneResult tune(Posterior& data, const EvidenceOptions& options, RandomStream& random, int term) {
  if (data.size() == 0) return {};
  if (data.over_budget()) return {0, 1};
  try {
    const EvidenceSummary best = maximize_evidence(data.prior(), data, options, random, term);
    data = condition(best.prior, data);
    return {best.evaluations, 0};
  } catch (const NumericalError&) {
    return {0, 1};
  }
}

TuneResult tune(Belief& belief, const Tuning& tuning, RandomStream& random) {
  TuneResult result;
  belief.for_each([&](int i, int column, Posterior& process, int term) {
    if (belief.points(i, column) < tuning.least_samples) return;
    const TuneResult one = tune(process, tuning.of(column), random, term);
    result.evaluations += one.evaluations;
    result.failed += one.failed;
  });
  return result;
}

void widen(Posterior& data) {
  const double excess = data.mean_squared_innovation();
  if (!(excess > 1.0)) return;
  std::optional<Posterior> best;  // none: as it was
  for (int term = 0; term < std::max(1, static_cast<int>(data.prior().terms.size())); ++term) {
    try {
      if (data.over_budget()) return data.scale_output(std::sqrt(excess));
      GaussianProcess prior = data.prior();
      scale_output(term_of(prior, term), std::sqrt(excess));
      Posterior wider = condition(prior, data);
      if (!best || wider.log_marginal_likelihood() > best->log_marginal_likelihood()) best = std::move(wider);
    } catch (const NumericalError&) {
      continue;
    }
  }
  if (best) data = *std::move(best);
}

}  // namespace bayesctrl
