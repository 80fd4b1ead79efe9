#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "physics/effect.hpp"

namespace bayesctrl {

/// A function of time over an interval: its value in the middle, and its slope.
struct Line {
  double middle = 0.0, slope = 0.0;
};

/// The line that has the mean and the first moment of value exp(-s / tau) over s in [0, h].
Line decaying(double value, double tau, double h);

/// Inputs of a recording of which samples were left out since. What a sample that stayed holds is a weighted sum of
/// them, and a map of the input acts on each of them before.
struct FineInput {
  Eigen::MatrixXd input;            // as it was recorded: rows x joints
  std::vector<Eigen::Index> stays;  // of each row: the sample that holds it,
  std::vector<double> own, late;    // its weight in that one, and in the next

  /// What the first `samples` samples hold of a value of each row, as many as there are values.
  Eigen::VectorXd held(const Eigen::VectorXd& values, Eigen::Index samples) const;
};

/// What an input is while samples hold no more than its mean: what is not linear in it, as the load on a bearing, needs
/// to know.
class InputSpread {
 public:
  InputSpread() = default;

  /// `values`: of each row of `fine`; they belong to `samples` samples.
  InputSpread(const FineInput& fine, const Eigen::VectorXd& values, Eigen::Index samples);

  /// Mean of |u - from| less |mean u - from|, while the sample is held; 0 where nothing is known of it.
  double unsteady(std::size_t sample, double from) const;

 private:
  struct Value {
    double u, weight;
  };
  struct Held {
    std::size_t first = 0;  // of its values
    double mean = 0.0, lowest = kInfinity, highest = -kInfinity;
  };

  std::vector<Value> values_;  // of one sample after the other
  std::vector<Held> samples_;  // and one behind the last
};

/// A sample before which nothing is known of the inputs, or not for a while. What a delay hides is then as it is there;
/// before the first sample of all it is 0.
struct Restart {
  std::size_t sample = 0;
  JointVector plays;  // how far they stand from the middle of their gaps about its inputs, per joint; empty: not known
};
using Restarts = std::vector<Restart>;  // in the order of the samples

/// The input of one joint as the machine feels it: constant between switches, behind a first-order lag if there is one.
/// It depends on the given input alone, never on the motion.
class Drive {
 public:
  /// Of `effects` those on the input of `joint` act, in the catalogue's order. Before the first sample a delayed input
  /// is 0; a lag has settled on the first value; a play rests at 0.
  Drive(const std::vector<Effect>& effects, int joint);

  /// A whole recording, or its beginning: `input` [k] is held from `time` [k] on; `fine`: of what it is the sum, if
  /// samples were left out. Plays stand where they follow the input to, or where they are known to.
  Drive(const std::vector<double>& time, const std::vector<double>& input, const std::vector<Effect>& effects,
        int joint, const FineInput* fine = nullptr, const Restarts& restarts = {});

  /// `input` is held from `time` on, which must increase.
  void append(double time, double input);

  /// Times at which the held value changes or may change, increasing.
  const std::vector<double>& switches() const { return time_; }

  /// Time constant of the lag; 0: none.
  double lag() const { return lag_; }

  /// Value at time t within segment `index`, switches()[index] <= t.
  double at(std::size_t index, double t) const;

  /// Over [t, t + h], within the same segment: the line of the same mean and first moment.
  Line over(std::size_t index, double t, double h) const;

  /// Whether a load feels more of the input than is held.
  bool has_spread() const { return !held_sample_.empty(); }

  /// In a segment: InputSpread. What a lag makes of an input is steady.
  double unsteady(std::size_t index, double from) const {
    return index < held_sample_.size() ? spread_.unsteady(held_sample_[index], from) : 0.0;
  }

 private:
  /// What maps and plays make of an input, in the order of time.
  double mapped(double input);
  void hold(double time, double mapped);

  std::vector<EffectForm> effects_;  // on this input, in order
  std::vector<double> play_;         // output of each effect that is a play,
  std::optional<double> departure_;  // and where it is to stand about the next input
  double delay_ = 0.0;
  double lag_ = 0.0;
  std::vector<double> time_;
  std::vector<double> held_;              // input of the lag
  std::vector<double> lagged_;            // output of the lag at the beginning of each segment
  InputSpread spread_;                    // where an effect of this joint asks for it,
  std::vector<std::size_t> held_sample_;  // and the sample that each segment holds
};

}  // namespace bayesctrl
