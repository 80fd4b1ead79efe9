#include "control/learner.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr double kGainShare = 0.25;  // of the threshold: variance of one sample of log b for which a probe is held
constexpr double kNews = 2.0;        // standard deviations beyond which a sample in passing is always learned

}  // namespace

bool uncertain(const BeliefMarginals& belief, int column, double threshold) {
  bool any = belief.log_gain_variance[column] > threshold;
  for (int i = 0; i < belief.log_gain_variance.size(); ++i) {
    any = any || (i != column && belief.gain_variance(i, column) > threshold);
  }
  return any;
}

std::optional<Probe> decide(const Learner& learner, const BeliefMarginals& belief, const JointVector& tolerated,
                            int last, long step) {
  const bool in_turn = learner.order == ProbeOrder::in_turn;
  const auto n = static_cast<int>(belief.drift_variance.size());
  const auto due = [&](int column) {
    if (column != Probe::kDrift) return uncertain(belief, column, learner.gain_threshold);
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

std::span<const double> span_of(const StateVector& x) { return {x.data(), static_cast<std::size_t>(x.size())}; }

/// What all inputs but `but` are believed to do to joint i.
Marginal of_inputs(const BeliefMarginals& believed, int i, JointVector u, int but = Probe::kDrift) {
  if (but != Probe::kDrift) u[but] = 0.0;
  if (u.isZero(0.0)) return {};  // also where a gain is believed to be without bound
  return {believed.gain_mean.row(i).dot(u), believed.gain_variance.row(i).dot(u.cwiseAbs2())};
}

/// Extends a process by one sample, with a noise of its own where it has one; one that cannot be taken is skipped.
void extend(Posterior& process, const StateVector& x, double y, std::optional<double> noise, Absorbed& result) {
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

/// The same, and notes in slot i how surprising it was, (y - E y) / sd y.
void learn(Posterior& process, int i, const StateVector& x, double y, std::optional<double> noise, Absorbed& result) {
  const Marginal before = process.predict(span_of(x));
  result.surprises[i] = (y - before.mean) / std::sqrt(before.variance + noise.value_or(process.prior().noise_variance));
  extend(process, x, y, noise, result);
}

}  // namespace

double asked_gain_variance(const Learner& learner) { return kGainShare * learner.gain_threshold; }

GainEstimate estimate_gain(const Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample) {
  const int n = belief.joints(), j = probe.column;
  const double u = sample.variance ? sample.input[j] : probing_input(learner, probe, n)[j];
  GainEstimate by_drift{JointVector(n), JointVector(n)};
  const BeliefMarginals believed = belief.predict(sample.x);
  for (int i = 0; i < n; ++i) {
    const Marginal others = of_inputs(believed, i, sample.input, j);
    const double measured = sample.variance ? (*sample.variance)[i] : 0.0;
    by_drift.value[i] = (sample.acceleration[i] - believed.drift_mean[i] - others.mean) / u;
    by_drift.variance[i] =
        (belief.drift(i).prior().noise_variance + believed.drift_variance[i] + measured + others.variance) / (u * u);
  }
  if (!sample.gain) return by_drift;
  const double jump = (*sample.gain)[j], variance = (*sample.gain_variance)[j];
  const bool enough = jump > 0.0 && variance <= asked_gain_variance(learner) * jump * jump;
  const bool better = variance < by_drift.variance[j];
  return enough || better ? GainEstimate{*sample.gain, *sample.gain_variance} : by_drift;
}

Absorbed absorb(Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample) {
  const int n = belief.joints();
  Absorbed result{0, 0, 0, JointVector::Zero(n)};
  if (probe.column == Probe::kDrift) {
    const BeliefMarginals believed = belief.predict(sample.x);
    for (int i = 0; i < n; ++i) {
      const Marginal late = of_inputs(believed, i, sample.input);  // what was held before and still acts
      const double target = sample.acceleration[i] - late.mean;
      std::optional<double> noise;
      if (sample.variance) noise = belief.drift(i).prior().noise_variance + (*sample.variance)[i] + late.variance;
      learn(belief.drift(i), i, sample.x, target, noise, result);
    }
    return result;
  }

  const int j = probe.column;
  const auto [estimate, variance] = estimate_gain(belief, learner, probe, sample);
  if (!(estimate[j] > 0.0) || !std::isfinite(estimate[j])) return {1, 0, 0, JointVector()};
  for (int i = 0; i < n; ++i) {
    Posterior& gain = belief.gain(i, j);
    const double target = i == j ? std::log(estimate[i]) : estimate[i];
    const double squared = i == j ? estimate[i] * estimate[i] : 1.0;
    std::optional<double> noise;
    if (learner.gain_noise == GainNoise::propagated) noise = variance[i] / squared;
    if (sample.variance) noise = variance[i] / squared + gain.prior().noise_variance;
    learn(gain, i, sample.x, target, noise, result);
  }
  return result;
}

Absorbed absorb_in_passing(Belief& belief, const Learner& learner, const Derivative& sample) {
  const int n = belief.joints();
  Absorbed result{0, 0, 0, JointVector::Zero(n)};
  const BeliefMarginals believed = belief.predict(sample.x);
  const JointVector u = sample.input, u_squared = u.cwiseAbs2();
  for (int i = 0; i < n; ++i) {
    const double measured = belief.drift(i).prior().noise_variance + (sample.variance ? (*sample.variance)[i] : 0.0);
    const Marginal inputs = of_inputs(believed, i, u);
    const double rest = sample.acceleration[i] - believed.drift_mean[i] - inputs.mean;
    const double open = believed.drift_variance[i] + inputs.variance;
    // Twice that of the inputs: samples in passing have its error in common.
    const double z = rest / std::sqrt(open + inputs.variance + measured);
    result.surprises[i] = z;
    if (open < std::min(learner.drift_threshold, measured) && std::abs(z) < kNews) continue;

    int vague = 0;  // input of the least known gain
    believed.gain_variance.row(i).transpose().cwiseProduct(u_squared).maxCoeff(&vague);
    const double by_gain = believed.gain_variance(i, vague) * u_squared[vague];
    const double estimate = believed.gain_mean(i, vague) + rest / u[vague];
    if (by_gain <= believed.drift_variance[i] || (i == vague && !(estimate > 0.0))) {
      const double noise = measured + open - believed.drift_variance[i];
      extend(belief.drift(i), sample.x, believed.drift_mean[i] + rest, noise, result);
      continue;
    }
    Posterior& gain = belief.gain(i, vague);
    const double scale = i == vague ? 1.0 / (estimate * estimate) : 1.0;
    const double noise = gain.prior().noise_variance + (measured + open - by_gain) / u_squared[vague] * scale;
    extend(gain, sample.x, i == vague ? std::log(estimate) : estimate, noise, result);
  }
  return result;
}

}  // namespace bayesctrl
