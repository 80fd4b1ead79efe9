#include "control/tuning.hpp"

namespace bayesctrl {

int tune(Posterior& data, const EvidenceOptions& options, RandomStream& random) {
  if (data.size() == 0) return 0;
  const EvidenceSummary best = maximize_evidence(data.prior(), data, options, random);
  data = condition(best.prior, data);
  return best.evaluations;
}

int tune(Belief& belief, const Tuning& tuning, RandomStream& random) {
  int evaluations = 0;
  for (int i = 0; i < belief.joints(); ++i) {
    evaluations += tune(belief.drift(i), tuning.evidence, random);
    for (int j = 0; j < belief.joints(); ++j) evaluations += tune(belief.gain(i, j), tuning.for_gain(), random);
  }
  return evaluations;
}

}  // namespace bayesctrl
