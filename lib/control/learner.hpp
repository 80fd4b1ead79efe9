#pragma once

#include <array>
#include <bitset>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "base/vector.hpp"
#include "control/belief.hpp"
#include "control/monitor.hpp"
#include "control/window.hpp"

namespace bayesctrl {

/// When learning may start: every `period` counted from t = 0, or `period` after the end of the last probe.
enum class Schedule { from_start, after_probe };
constexpr std::array<std::string_view, 2> names(Schedule) { return {"from_start", "after_probe"}; }

/// Noise of a sample of log b: the prior's, or the paper's Eq. for var b_j, (var x2' + var a) / u_j^2, carried through
/// the logarithm (divided by b_j^2). Samples from windows have the prior's and their own.
enum class GainNoise { prior, propagated };
constexpr std::array<std::string_view, 2> names(GainNoise) { return {"prior", "propagated"}; }

/// What is probed where several functions are uncertain: the drift as long as it is, or each in its turn, the drift
/// only where one sample would halve its variance.
enum class ProbeOrder { drift_first, in_turn };
constexpr std::array<std::string_view, 2> names(ProbeOrder) { return {"drift_first", "in_turn"}; }

/// When to learn, and by which probing action (the paper's learning procedure).
struct Learner {
  double period = 1.0;
  double drift_threshold = 1e-3;
  double gain_threshold = 5e-3;
  std::vector<double> probing_input{1.0};
  Schedule schedule = Schedule::from_start;
  int hold_periods = 3;
  GainNoise gain_noise = GainNoise::prior;
  ProbeOrder order = ProbeOrder::drift_first;
  double error_share = 0.0;
  std::optional<DerivativeWindow> window;
  std::optional<Monitor> monitor;

  static void fields(auto& self, auto&& field) {
    field("period", self.period,
          {kPositive, "s", "time between learning instants, the paper's Delta_lambda", kRequired});
    field("drift_threshold", self.drift_threshold,
          {kPositive, "(rad/s^2)^2", "learn a where its latent variance exceeds this, theta_a", kRequired});
    field("gain_threshold", self.gain_threshold,
          {kPositive, "nat^2",
           "learn b_j where the latent variance of log b_jj exceeds this, theta_b, or that of a b_ij (with a monitor "
           "over b_ii b_jj)",
           kRequired});
    field("probing_input", self.probing_input,
          {kAny, "unit of u", "u_j of the probe of b_j, one or one per input", kRequired});
    field("schedule", self.schedule, {.text = "count the period from t = 0 or from the end of the last probe"});
    field("hold_periods", self.hold_periods,
          {between(2, 1000), "", "control periods for which a probe holds its input"});
    field(
        "gain_noise", self.gain_noise,
        {.text = "noise of a sample of log b: the prior's, or propagated from var a; over windows always propagated"});
    field(
        "order", self.order,
        {.text = "probe a until it is certain, or a and each column of b in turn, a where a sample would be worth it"});
    field("error_share", self.error_share,
          {kNonNegative, "1/s",
           "a is not probed either where its standard deviation is below so much of the tracking error r = e' + "
           "sqrt(w1) e"});
    field("window", self.window,
          {.text = "derivatives from windows of samples, with their variance; null: from three"});
    field("monitor", self.monitor,
          {.text =
               "learn a and b together and in passing, and widen the prior where its errors are too large; null: only "
               "by probes"});
  }

  std::string problem() const {
    for (const double u : probing_input) {
      if (u == 0.0) return "probing_input must not be 0: b cannot be seen without an input";
    }
    return "";
  }
  bool operator==(const Learner&) const = default;
};

/// A running probe: which function is being learned, since which control step.
struct Probe {
  static constexpr int kDrift = -1;
  int column = kDrift;  // of b, or kDrift
  long start = 0;
};

/// Whether a column of b is uncertain by so many `thresholds`: the variance of log b_jj or, beside the diagonal, that
/// of b_ij; with a monitor that of b_ij over b_ii b_jj: for an inverse inertia |b_ij| < sqrt(b_ii b_jj).
bool uncertain(const Learner& learner, const BeliefMarginals& belief, int column, double thresholds = 1.0);

/// What the learner decides at a learning instant: the drift where it is uncertain, else the first uncertain column of
/// b, else nothing; in turn the first that is uncertain after the column `last`. The drift's threshold is not below
/// `tolerated`, a variance for each joint; columns of b that are `wanted` are as if they were uncertain.
std::optional<Probe> decide(const Learner& learner, const BeliefMarginals& belief, const JointVector& tolerated,
                            int last, long step, std::bitset<kMaxJoints> wanted = {});

/// The input that a probe holds: 0 for the drift, u_j e_j for column j.
JointVector probing_input(const Learner& learner, const Probe& probe, int inputs);

/// State and acceleration at one time, and the input that acted then. Without a variance the prior's noise is a
/// sample's.
struct Derivative {
  StateVector x;  // [q, v]
  JointVector acceleration;
  JointVector input;                                   // mean over what the acceleration was measured on
  std::optional<JointVector> variance{};               // of the acceleration
  std::optional<JointVector> gain{}, gain_variance{};  // of the probed column, where it was measured without the drift
};

/// The paper's second-order estimate (x(t + 2 dt) - x(t)) / (2 dt) of the velocity's derivative, at t + dt.
Derivative estimate_from_states(const std::array<StateVector, 3>& x, double dt);

/// From positions only: v = (q2 - q0) / (2 dt), q'' = (q2 - 2 q1 + q0) / dt^2.
Derivative estimate_from_positions(const std::array<StateVector, 3>& x, double dt);

/// The probed column of b, one value per joint.
struct GainEstimate {
  JointVector value, variance;
  bool by_jump = false;  // told by the jump of the input, without a
};

/// Eq. (5) and (6) of the paper, by what is believed of the drift. Where a jump of the input told b without it, that is
/// the estimate if its relative variance is at most `asked_gain_variance`, or less than that of the other.
GainEstimate estimate_gain(const Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample);

/// Relative variance of an estimate of b_jj with which a probe is content.
double asked_gain_variance(const Learner& learner);

/// What became of a sample.
struct Absorbed {
  int refused = 0;        // estimates of a gain that were not positive: the whole column's sample is left out
  int skipped = 0;        // samples that a process could not take: a repetition without noise, for example
  int taken = 0;          // samples that extended a process
  JointVector surprises;  // (y - E y) / sd y of what was learned, by what was believed before
};

/// Absorbs the sample of one finished probe into the belief.
Absorbed absorb(Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample);

/// Absorbs a sample that was taken without a probe, q'' = a(x) + sum_j b_j(x) u_j, into a belief whose processes are
/// together, where it is news: not where q'' is known to within the drift's threshold, and better than it is measured,
/// and nothing surprises.
Absorbed absorb_in_passing(Belief& belief, const Learner& learner, const Derivative& sample);

}  // namespace bayesctrl
