#include "control/tuning.hpp"

#include <cmath>

#include "base/error.hpp"

namespace bayesctrl {

TuneResult tune(Posterior& data, const EvidenceOptions& options, RandomStream& random) {
  if (data.size() == 0) return {};
  if (data.over_budget()) return {0, 1};
  try {
    const EvidenceSummary best = maximize_evidence(data.prior(), data, options, random);
    data = condition(best.prior, data);
    return {best.evaluations, 0};
  } catch (const NumericalError&) {
    return {0, 1};
  }
}

TuneResult tune(Belief& belief, const Tuning& tuning, RandomStream& random) {
  TuneResult result;
  const auto add = [&](Posterior& process, const EvidenceOptions& options) {
    if (process.size() < tuning.least_samples) return;
    const TuneResult one = tune(process, options, random);
    result.evaluations += one.evaluations;
    result.failed += one.failed;
  };
  for (int i = 0; i < belief.joints(); ++i) {
    add(belief.drift(i), tuning.evidence);
    for (int j = 0; j < belief.joints(); ++j) add(belief.gain(i, j), tuning.for_gain());
  }
  return result;
}

void widen(Posterior& data) {
  const double excess = data.mean_squared_innovation();
  if (!(excess > 1.0)) return;
  try {
    if (data.over_budget()) return data.scale_output(std::sqrt(excess));
    GaussianProcess prior = data.prior();
    scale_output(prior.kernel, std::sqrt(excess));
    data = condition(prior, data);
  } catch (const NumericalError&) {
    return;  // as it was
  }
}

}  // namespace bayesctrl
