#pragma once

#include "diagnose/recording/measured.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// A model and recordings of what it is to describe: what a spec says, or would say without a mistake.
struct Scene {
  Plant plant;
  std::vector<Measured> data;
  std::vector<std::string> free = {};  // parameters of the plant that may be re-estimated
};

/// Motion as samples alone tell it, no model helping: on uniform grids, smoothed by one Gaussian and no finer than
/// that asks for.
struct Kinematics {
  struct Stretch {
    double start = 0.0, period = 0.0;                  // s
    Eigen::MatrixXd position, velocity, acceleration;  // of the smoothed motion: samples x joints
    Eigen::MatrixXd input;                             // not smoothed: mean of what acts about each sample
  };
  std::vector<Stretch> stretches;
  double width = 0.0;  // standard deviation of the Gaussian, s
};

/// `joints` of the machine. The Gaussian is the narrowest that leaves little of the noise in accelerations; it stays
/// far below the period of the motion. No stretch where samples are too few.
Kinematics observe(const std::vector<Measured>& data);

/// Observes recordings, and then the same with something changed: what is as it was is not smoothed again.
class Observer {
 public:
  explicit Observer(std::vector<Measured> data) : data_(std::move(data)), seen_(observe(data_)) {}

  /// observe(changed)
  Kinematics operator()(const std::vector<Measured>& changed) const;

 private:
  std::vector<Measured> data_;
  Kinematics seen_;
};

/// Part of the accelerations, squares, that a plant leaves unexplained where each joint may have viscous and dry
/// friction and a constant torque beside it: near 0 for a good model, 1 for one that says nothing. Infinite where the
/// plant gives no numbers.
double unexplained(const Plant& plant, const Kinematics& seen);

/// Part of what a plant without its input leaves of the accelerations that the input explains at any lag up to half a
/// second, and the most that inputs explain which cannot: its own, moved by a good part of the recording, or backwards.
struct Answer {
  double input_share = 0.0;  // of the accelerations, that the plant expects of the input
  double explained = 1.0, by_chance = 0.0;

  /// Nothing in the motion answers to an input that should matter.
  bool none() const;
};
Answer answer_to_input(const Plant& plant, const Kinematics& seen);

}  // namespace bayesctrl
