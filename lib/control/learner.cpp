#include "control/learner.hpp"

#include <cmath>

namespace bayesctrl {

std::optional<Probe> decide(const Learner& learner, const BeliefMarginals& belief, long step) {
  if ((belief.drift_variance.array() > learner.drift_threshold).any()) return Probe{Probe::kDrift, step};
  const auto n = belief.drift_variance.size();
  for (int j = 0; j < n; ++j) {
    bool uncertain = belief.log_gain_variance[j] > learner.gain_threshold;
    for (int i = 0; i < n; ++i)
      uncertain = uncertain || (i != j && belief.gain_variance(i, j) > learner.gain_threshold);
    if (uncertain) return Probe{j, step};
  }
  return std::nullopt;
}

JointVector probing_input(const Learner& learner, const Probe& probe, int inputs) {
  JointVector u = JointVector::Zero(inputs);
  if (probe.column != Probe::kDrift) {
    u[probe.column] =
        learner.probing_input.size() == 1 ? learner.probing_input[0] : learner.probing_input[probe.column];
  }
  return u;
}

Derivative estimate_from_states(const std::array<StateVector, 3>& x, double dt) {
  const Eigen::Index n = x[0].size() / 2;
  return {x[1], (x[2].tail(n) - x[0].tail(n)) / (2.0 * dt)};
}

Derivative estimate_from_positions(const std::array<StateVector, 3>& x, double dt) {
  const Eigen::Index n = x[0].size() / 2;
  Derivative result{x[1], (x[2].head(n) - 2.0 * x[1].head(n) + x[0].head(n)) / (dt * dt)};
  result.x.tail(n) = (x[2].head(n) - x[0].head(n)) / (2.0 * dt);
  return result;
}

int absorb(Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample) {
  const int n = belief.joints();
  const std::span<const double> x(sample.x.data(), static_cast<std::size_t>(sample.x.size()));
  if (probe.column == Probe::kDrift) {
    for (int i = 0; i < n; ++i) belief.drift(i).extend(x, sample.acceleration[i]);
    return 0;
  }

  const int j = probe.column;
  const double u = probing_input(learner, probe, n)[j];
  JointVector estimate(n), variance(n);
  for (int i = 0; i < n; ++i) {
    const Marginal drift = belief.drift(i).predict(x);
    estimate[i] = (sample.acceleration[i] - drift.mean) / u;
    variance[i] = (belief.drift(i).prior().noise_variance + drift.variance) / (u * u);
  }
  if (!(estimate[j] > 0.0)) return 1;
  for (int i = 0; i < n; ++i) {
    Posterior& gain = belief.gain(i, j);
    const double target = i == j ? std::log(estimate[i]) : estimate[i];
    const double propagated = i == j ? variance[i] / (estimate[i] * estimate[i]) : variance[i];
    if (learner.gain_noise == GainNoise::propagated) {
      gain.extend(x, target, propagated);
    } else {
      gain.extend(x, target);
    }
  }
  return 0;
}

}  // namespace bayesctrl
