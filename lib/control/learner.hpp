#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "base/vector.hpp"
#include "control/belief.hpp"

namespace bayesctrl {

/// When learning may start: every `period` counted from t = 0, or `period` after the end of the last probe.
enum class Schedule { from_start, after_probe };
constexpr std::array<std::string_view, 2> names(Schedule) { return {"from_start", "after_probe"}; }

/// Noise of a sample of log b: the prior's, or the paper's Eq. for var b_j, (var x2' + var a) / u_j^2, carried through
/// the logarithm (divided by b_j^2).
enum class GainNoise { prior, propagated };
constexpr std::array<std::string_view, 2> names(GainNoise) { return {"prior", "propagated"}; }

/// When to learn, and by which probing action (the paper's learning procedure).
struct Learner {
  double period = 1.0;
  double drift_threshold = 1e-3;
  double gain_threshold = 5e-3;
  std::vector<double> probing_input{1.0};
  Schedule schedule = Schedule::from_start;
  int hold_periods = 3;
  GainNoise gain_noise = GainNoise::prior;

  static void fields(auto& self, auto&& field) {
    field("period", self.period,
          {kPositive, "s", "time between learning instants, the paper's Delta_lambda", kRequired});
    field("drift_threshold", self.drift_threshold,
          {kPositive, "(rad/s^2)^2", "learn a where its latent variance exceeds this, theta_a", kRequired});
    field("gain_threshold", self.gain_threshold,
          {kPositive, "nat^2", "learn b_j where the latent variance of log b_jj exceeds this, theta_b", kRequired});
    field("probing_input", self.probing_input,
          {kAny, "unit of u", "u_j of the probe of b_j, one or one per input", kRequired});
    field("schedule", self.schedule, {.text = "count the period from t = 0 or from the end of the last probe"});
    field("hold_periods", self.hold_periods,
          {between(2, 1000), "", "control periods for which a probe holds its input"});
    field("gain_noise", self.gain_noise, {.text = "noise of a sample of log b: the prior's, or propagated from var a"});
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

/// What the learner decides at a learning instant: the drift where it is uncertain, else the first uncertain column of
/// b, else nothing. A column is uncertain by log b_jj or, beside the diagonal, by b_ij (same threshold).
std::optional<Probe> decide(const Learner& learner, const BeliefMarginals& belief, long step);

/// The input that a probe holds: 0 for the drift, u_j e_j for column j.
JointVector probing_input(const Learner& learner, const Probe& probe, int inputs);

/// State and acceleration in the middle of three samples at t, t + dt, t + 2 dt.
struct Derivative {
  StateVector x;  // [q, v] at t + dt
  JointVector acceleration;
};

/// The paper's second-order estimate (x(t + 2 dt) - x(t)) / (2 dt) of the velocity's derivative.
Derivative estimate_from_states(const std::array<StateVector, 3>& x, double dt);

/// From positions only: v = (q2 - q0) / (2 dt), q'' = (q2 - 2 q1 + q0) / dt^2.
Derivative estimate_from_positions(const std::array<StateVector, 3>& x, double dt);

/// Absorbs the sample of one finished probe into the belief. Returns the number of refused estimates: a diagonal gain
/// that is not positive has no logarithm, and the whole column's sample is left out.
int absorb(Belief& belief, const Learner& learner, const Probe& probe, const Derivative& sample);

}  // namespace bayesctrl
