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

/// The input of one joint as the machine feels it: constant between switches, behind a first-order lag if there is one.
/// It depends on the given input alone, never on the motion.
class Drive {
 public:
  /// Of `effects` those on the input of `joint` act, in the catalogue's order. Before the first sample a delayed input
  /// is 0; a lag has settled on the first value; a play rests at 0, or stands so far from the middle of its gap about
  /// the first input as `play` says.
  Drive(const std::vector<Effect>& effects, int joint, std::optional<double> play = {});

  /// A whole recording, or its beginning: `input` [k] is held from `time` [k] on; `fine`: of what it is the sum, if
  /// samples were left out.
  Drive(const std::vector<double>& time, const std::vector<double>& input, const std::vector<Effect>& effects,
        int joint, const FineInput* fine = nullptr, std::optional<double> play = {});

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

 private:
  /// What maps and plays make of an input, in the order of time.
  double mapped(double input);
  void hold(double time, double mapped);

  std::vector<EffectForm> effects_;  // on this input, in order
  std::vector<double> play_;         // output of each effect that is a play,
  std::optional<double> departure_;  // and where it begins about the first input
  double delay_ = 0.0;
  double lag_ = 0.0;
  std::vector<double> time_;
  std::vector<double> held_;    // input of the lag
  std::vector<double> lagged_;  // output of the lag at the beginning of each segment
};

}  // namespace bayesctrl
