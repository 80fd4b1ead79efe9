#include "control/learner.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr double kGainShare = 0.25;  // of the threshold: variance of one sample of log b for which a probe is held
constexpr double kNews = 2.0;        // standard deviations beyond which a sample in passing is always learned
constexpr double kFar = 4.0;         // nats by which a sample that is not its own may change log b: e^l is not linear

}  // namespace

bool uncertain(const Learner& learner, const BeliefMarginals& belief, int column, double thresholds) {
  const double threshold = thresholds * learner.gain_threshold;
  bool any = belief.log_gain_variance[column] > threshold;
  for (int i = 0; i < belief.log_gain_variance.size(); ++i) {
    const double scale = learner.monitor ? std::exp(belief.log_gain_mean[i] + belief.log_gain_mean[column]) : 1.0;
    any = any || (i != column && belief.gain_variance(i, column) > threshold * scale);
  }
  return any;
}

std::optional<Probe> decide(const Learner& learner, const BeliefMarginals& belief, const JointVector& tolerated,
                            int last, long step, std::bitset<kMaxJoints> wanted) {
  const bool in_turn = learner.order == ProbeOrder::in_turn;
  const auto n = static_cast<int>(belief.drift_variance.size());
  const auto due = [&](int column) {
    if (column != Probe::kDrift) {
      return wanted[static_cast<std::size_t>(column)] || uncertain(learner, belief, column);
    }
    bool any = false;
    for (int i = 0; i < n; ++i) {
      any = any || belief.drift_variance[i] > std::max(learner.drift_threshold, tolerated[i]);
    }
    return any;
  };
  const int first = in_turn ? last + 1 : Probe::kDrift;
  for (int turn = 0; turn <= n; ++turn) {
    const int column = (first - Probe::kDrift + turn) % (n + 1) + Probe::kDrift;
    if (due(column)) return Probe{column, step};
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
  return {x[1], (x[2].tail(n) - x[0].tail(n)) / (2.0 * dt), JointVector::Zero(n), {}};
}

Derivative estimate_from_positions(const std::array<StateVector, 3>& x, double dt) {
  const Eigen::Index n = x[0].size() / 2;
  Derivative result{x[1], (x[2].head(n) - 2.0 * x[1].head(n) + x[0].head(n)) / (dt * dt), JointVector::Zero(n), {}};
  result.x.tail(n) = (x[2].head(n) - x[0].head(n)) / (2.0 * dt);
  return result;
}

namespace {

/// Extends a process by one sample, with a noise of its own where it has one, and notes in slot i how surprising it
/// was, (y - E y) / sd y; a sample that cannot be taken is skipped.
void learn(Posterior& process, int i, const StateVector& x, double y, std::optional<double> noise, Absorbed& result) {
  const Marginal before = process.predict(span_of(x));
  result.surprises[i] = (y - before.mean) / std::sqrt(before.variance + noise.value_or(process.prior().noise_variance));
  try {
    if (noise) {
      process.extend(span_of(x), y, *noise);
    } else {
      process.extend(span_of(x), y);
    }
    ++result.taken;
  } catch (const NumericalError&) {
    ++result.skipped;
  }
}

}  // namespace

double asked_gain_variance(const Learner& learner) { return kGainShare * learner.gain_threshold; }

GainEstimate estimate_gain(const Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample) {
  const int n = belief.joints(), j = probe.column;
  const double u = sample.variance ? sample.input[j] : probing_input(learner, probe, n)[j];
  GainEstimate by_drift{JointVector(n), JointVector(n), false};
  const BeliefMarginals believed = belief.predict(sample.x);
  JointVector others = sample.input;
  others[j] = 0.0;
  for (int i = 0; i < n; ++i) {
    const Marginal rest = belief.acceleration(believed, i, sample.x, others);
    const double measured = sample.variance ? (*sample.variance)[i] : 0.0;
    by_drift.value[i] = (sample.acceleration[i] - rest.mean) / u;
    by_drift.variance[i] = (belief.drift_prior(i).noise_variance + rest.variance + measured) / (u * u);
  }
  if (!sample.gain) return by_drift;
  const double jump = (*sample.gain)[j], variance = (*sample.gain_variance)[j];
  const bool enough = jump > 0.0 && variance <= asked_gain_variance(learner) * jump * jump;
  const bool better = variance < by_drift.variance[j];
  return enough || better ? GainEstimate{*sample.gain, *sample.gain_variance, true} : by_drift;
}

namespace {

/// Whether an estimate is refused: of b_jj something positive is asked.
bool refused(const GainEstimate& gain, int column) {
  return !(gain.value[column] > 0.0) || !std::isfinite(gain.value[column]);
}

/// A sample of one joint's weighted sum.
struct SumSample {
  TermVector weights;
  double target, noise;
};

/// q_i'' = a_i + sum_j b_ij u_j as one, e^l of l = log b_ii being linearised where l is believed to be, together with
/// what the sample itself says of it, `told`: its curvature there is part of the target and of the noise.
SumSample linearised(const Belief& belief, const BeliefMarginals& believed, int i, const Derivative& sample,
                     const JointVector& u, const std::optional<Marginal>& told) {
  SumSample result{TermVector(u.size() + 1), sample.acceleration[i], belief.drift_prior(i).noise_variance};
  if (sample.variance) result.noise += (*sample.variance)[i];
  result.weights << 1.0, u;
  if (u[i] != 0.0) {
    const double share = told ? believed.log_gain_variance[i] / (believed.log_gain_variance[i] + told->variance) : 0.0;
    const double l = believed.log_gain_mean[i] + (told ? share * (told->mean - believed.log_gain_mean[i]) : 0.0);
    const double open = (1.0 - share) * believed.log_gain_variance[i];
    const double slope = u[i] * std::exp(l);
    result.weights[i + 1] = slope;
    result.target -= slope * (1.0 - l + 0.5 * open);
    result.noise += 0.5 * slope * slope * open * open;
  }
  for (int j = 0; j < u.size(); ++j) {
    result.noise += std::pow(result.weights[j + 1], 2) * belief.gain_prior(i, j).noise_variance;
  }
  return result;
}

/// The same with b_ii as it is believed to be, its variance noise: what the sample says of a_i and the other b_ij.
SumSample without_own_gain(SumSample sample, const BeliefMarginals& believed, int i, const Derivative& measured,
                           const JointVector& u) {
  const double curved = std::pow(sample.weights[i + 1] * believed.log_gain_variance[i], 2);
  sample.weights[i + 1] = 0.0;
  sample.target = measured.acceleration[i] - u[i] * believed.gain_mean(i, i);
  sample.noise += u[i] * u[i] * believed.gain_variance(i, i) - 0.5 * curved;
  return sample;
}

/// By how much a sample would change log b_ii, given the covariance of the terms.
double change_of_log_gain(const TermMatrix& covariance, int i, const SumSample& told, const Marginal& before) {
  return covariance.row(i + 1).dot(told.weights) * (told.target - before.mean) / (before.variance + told.noise);
}

/// What a belief whose processes are together learns from the sample of a probe, or of none.
Absorbed absorb_together(Belief& belief, const Learner& learner, const std::optional<Probe>& probe,
                         const Derivative& sample) {
  const int n = belief.joints(), column = probe ? probe->column : Probe::kDrift;
  Absorbed result{0, 0, 0, JointVector::Zero(n)};
  const BeliefMarginals believed = belief.predict(sample.x);
  const JointVector u = sample.variance || !probe ? sample.input : probing_input(learner, *probe, n);
  GainEstimate gain;
  if (column != Probe::kDrift) {
    gain = estimate_gain(belief, learner, *probe, sample);
    if (refused(gain, column)) return {1, 0, 0, JointVector()};
  }
  for (int i = 0; i < n; ++i) {
    std::optional<Marginal> estimate;  // of b_ij, or of log b_ii
    if (column != Probe::kDrift) {
      const double value = gain.value[i], variance = gain.variance[i];
      estimate = i == column ? Marginal{std::log(value), variance / (value * value)} : Marginal{value, variance};
    }
    SumSample told;
    if (gain.by_jump) {
      told = {TermVector::Unit(n + 1, column + 1), estimate->mean,
              estimate->variance + belief.gain_prior(i, column).noise_variance};
    } else {
      told = linearised(belief, believed, i, sample, u, i == column ? estimate : std::nullopt);
    }
    Marginal before = belief.predict(i, sample.x, told.weights);
    result.surprises[i] = (told.target - before.mean) / std::sqrt(before.variance + told.noise);
    if (!gain.by_jump && i != column) {
      const TermMatrix covariance = belief.motion(i).predict_terms(span_of(sample.x)).covariance;
      if (std::abs(change_of_log_gain(covariance, i, told, before)) > kFar) {
        told = without_own_gain(told, believed, i, sample, u);
        before = belief.predict(i, sample.x, told.weights);
        const double far = std::abs(change_of_log_gain(covariance, i, told, before)) / kFar;  // by way of a_i
        told.noise += std::max(0.0, far - 1.0) * (before.variance + told.noise);
      }
    }
    const bool known = before.variance < std::min(learner.drift_threshold, told.noise);
    if (!probe && known && std::abs(result.surprises[i]) < kNews) continue;
    try {
      belief.learn(i, sample.x, told.weights, told.target, told.noise);
      ++result.taken;
    } catch (const NumericalError&) {
      ++result.skipped;
    }
  }
  return result;
}

}  // namespace

Absorbed absorb(Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample) {
  if (belief.together()) return absorb_together(belief, learner, probe, sample);
  const int n = belief.joints();
  Absorbed result{0, 0, 0, JointVector::Zero(n)};
  if (probe.column == Probe::kDrift) {
    const BeliefMarginals believed = belief.predict(sample.x);
    for (int i = 0; i < n; ++i) {
      const Marginal late = believed.of_inputs(i, sample.input);  // what was held before and still acts
      const double target = sample.acceleration[i] - late.mean;
      std::optional<double> noise;
      if (sample.variance) noise = belief.drift(i).prior().noise_variance + (*sample.variance)[i] + late.variance;
      learn(belief.drift(i), i, sample.x, target, noise, result);
    }
    return result;
  }

  const int j = probe.column;
  const GainEstimate estimate = estimate_gain(belief, learner, probe, sample);
  if (refused(estimate, j)) return {1, 0, 0, JointVector()};
  for (int i = 0; i < n; ++i) {
    Posterior& gain = belief.gain(i, j);
    const double value = estimate.value[i], variance = estimate.variance[i] / (i == j ? value * value : 1.0);
    const double target = i == j ? std::log(value) : value;
    std::optional<double> noise;
    if (learner.gain_noise == GainNoise::propagated) noise = variance;
    if (sample.variance) noise = variance + gain.prior().noise_variance;
    learn(gain, i, sample.x, target, noise, result);
  }
  return result;
}

Absorbed absorb_in_passing(Belief& belief, const Learner& learner, const Derivative& sample) {
  return absorb_together(belief, learner, std::nullopt, sample);
}

}  // namespace bayesctrl
