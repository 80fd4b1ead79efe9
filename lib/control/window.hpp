#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "base/fields.hpp"
#include "base/vector.hpp"

namespace bayesctrl {

/// Derivatives from windows of samples, with their variance, in the place of three samples; for sensors with noise, and
/// machines on which an input acts late.
struct DerivativeWindow {
  double longest = 0.2;
  double longest_in_passing = 0.5;
  double accuracy = 0.05;
  double longest_delay = 0.05;

  static void fields(auto& self, auto&& field) {
    field("longest", self.longest,
          {kPositive, "s", "longest window, and so the longest probe that noise makes necessary"});
    field("longest_in_passing", self.longest_in_passing,
          {kPositive, "s",
           "longest window in passing where noise makes the longest probe too short: as long as drift_threshold asks, "
           "while the machine hardly moves"});
    field("accuracy", self.accuracy,
          {kPositive, "rad/s^2", "standard deviation of an acceleration up to which a probe is held"});
    field("longest_delay", self.longest_delay,
          {between(0, 1), "s", "delays and lags of input or sensor up to this are estimated from the first probes"});
  }
  bool operator==(const DerivativeWindow&) const = default;
};

/// How late an input acts on what is seen: a pure delay, and after it a lag of first order.
struct Timing {
  double delay = 0.0;  // s
  double lag = 0.0;    // s
  double together() const { return delay + lag; }
  bool operator==(const Timing&) const = default;
};

/// Of each input.
using Timings = std::vector<Timing>;

/// The one that acts last.
Timing latest(const Timings& timings);

/// The last measured states and held inputs of a run, by the number of the control call.
class History {
 public:
  History() = default;
  History(int joints, int capacity);

  /// Call k, the next one: what was seen, and the input that was held before it (of call k - 1).
  void add(const StateVector& seen);
  void hold(const JointVector& input);

  long calls() const { return calls_; }
  int joints() const { return joints_; }

  const StateVector& seen(long k) const { return seen_[static_cast<std::size_t>(k % capacity_)]; }

  /// The input held from call k to k + 1; 0 before the first, the oldest for what is no longer kept.
  JointVector input(long k) const;

 private:
  int joints_ = 0, capacity_ = 1;
  long calls_ = 0, held_ = 0;
  std::vector<StateVector> seen_;
  std::vector<JointVector> inputs_;
};

/// What an input that acts with `timing` has done to the motion since the first call of a window: of one input, at each
/// call of it, the integrals of its acting value by time, once and twice.
struct InputMotion {
  double mean = 0.0;  // of the acting input over the window
  Eigen::VectorXd once, twice;
};

/// Least squares of a window of n equally spaced samples of the positions (or of the velocities, where they are
/// measured) by a motion whose acceleration changes linearly, q = q_c + v_c s + a_c s^2/2 + j s^3/6 around the middle.
class WindowFit {
 public:
  /// `samples` >= 4 of velocities, >= 5 of positions.
  WindowFit(int samples, double dt, bool positions_only);

  int samples() const { return static_cast<int>(weights_.cols()); }

  /// Variance of a_c for a noise variance of 1.
  double acceleration_variance() const { return acceleration_variance_; }
  int degrees_of_freedom() const { return samples() - static_cast<int>(weights_.rows()); }

  struct Result {
    double position = 0.0, velocity = 0.0, acceleration = 0.0, jerk = 0.0;  // in the middle
    double rest = 0.0;                                                      // sum of squared residuals
  };

  /// `positions`, and `velocities` where they are measured, of one joint.
  Result operator()(const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities) const;

 private:
  bool positions_only_;
  Eigen::VectorXd times_;    // around the middle
  Eigen::MatrixXd basis_;    // samples x parameters
  Eigen::MatrixXd weights_;  // parameters x samples: the least squares' solution
  double acceleration_variance_ = 0.0;
};

/// The motion of input j over `samples` calls from call `first`.
InputMotion motion_of_input(const History& history, int input, long first, int samples, double dt,
                            const Timing& timing);

/// One column of the input gain from the jump of its input at the beginning of a probe: the motion from before it to
/// after it is that of an acceleration which changes linearly, and of b times the input. What is believed of the drift
/// does not matter. One value per joint.
struct JumpFit {
  JointVector gain, factor;    // b_ij, and the factor of a sensor's noise variance in its variance
  JointVector bias;            // by how much b_ij changes if the acceleration's second derivative is allowed for
  JointVector rest;            // sums of squared residuals
  int degrees_of_freedom = 0;  // 0: the input did not change enough to tell
};

/// Of input j from call `first` to call `last`, the motion that the other inputs made taken away by `believed`.
JumpFit fit_jump(const History& history, int input, long first, long last, double dt, bool positions_only,
                 const Timings& timings, const JointMatrix& believed);

/// The delay and the lag of each input that explain probes best: a probe's jump of its input changes the acceleration,
/// and when it does is read from a grid of delays and lags, the likelihoods of all probes of one input together.
class TimingEstimate {
 public:
  TimingEstimate() = default;
  explicit TimingEstimate(Timings timings) : best_(std::move(timings)) {}  // which are known
  TimingEstimate(int inputs, double longest, double dt, bool positions_only);

  /// Takes the calls from `first` to `last`, if one input alone changes then; whether it did.
  bool add(const History& history, long first, long last);

  const Timings& best() const { return best_; }

  /// Whether the probes have told the delays of every input apart, or of one.
  bool known() const;
  bool known(int input) const { return inputs_.empty() || inputs_[static_cast<std::size_t>(input)].known; }

 private:
  struct OfInput {
    bool known = false;
    int probes = 0;
    std::vector<double> log_likelihood;  // over the grid
  };

  double dt_ = 0.01;
  bool positions_only_ = false;
  std::vector<Timing> grid_;
  std::vector<OfInput> inputs_;  // none where they are known
  Timings best_;
};

}  // namespace bayesctrl
