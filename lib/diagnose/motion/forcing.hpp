#pragma once

#include <array>

#include "diagnose/motion/smoother.hpp"
#include "physics/effect.hpp"
#include "physics/machine/drive.hpp"

namespace bayesctrl {

/// What effects do along a known motion: the acceleration that each adds between neighbouring samples. Everything that
/// does not depend on the effect is computed once.
class Forcing {
 public:
  Forcing(const Plant& plant, const std::vector<Measured>& data, const std::vector<Trajectory>& paths);

  /// Mean acceleration from sample k to k + 1 in row k, joints in columns; zero where the effect does not act. Sensor
  /// effects accelerate nothing. Springs `beside` the effect load what rubs.
  Eigen::MatrixXd acceleration(const Effect& effect, std::size_t recording,
                               const std::vector<Effect>& beside = {}) const;

  /// The same of a whole set; effects on one joint's input act one after the other.
  Eigen::MatrixXd acceleration(const std::vector<Effect>& effects, std::size_t recording) const;

  /// The missing torque of a joint while it rests, as an acceleration: what dry friction holds there, whatever its
  /// level. Zero in all rows where the joint never rests for long.
  Eigen::MatrixXd held(int joint, std::size_t recording) const;

  /// A torque in a joint for as long as it rests, as accelerations in the order of the response's rows, at most as
  /// large as the nominal's: per recording, one column for each of the longest rests in all of them.
  std::vector<Eigen::MatrixXd> resting(int joint, int most) const;

  /// What a sensor effect adds to the measured positions; zero for all others.
  Eigen::MatrixXd measured(const Effect& effect, std::size_t recording) const;

  /// Acceleration along the motion of one plant less that of the nominal: the effect of its parameters.
  Eigen::MatrixXd acceleration(const Plant& other, std::size_t recording) const;

  /// Mean acceleration from sample k to k + 1 in row k that another plant with effects, none of them of a sensor, has
  /// where the motion is. Of state and input alone: added inertia divides what moves a joint, and does not ask how it
  /// moves, so that what a motion does beside it is as it would be in the machine. Dry friction holds a joint at rest
  /// as far as it can.
  Eigen::MatrixXd total(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const;

  /// What that plant and the effects without inertia add to the nominal's acceleration; the same of what they add.
  Eigen::MatrixXd added(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const;
  Eigen::MatrixXd total(Eigen::MatrixXd added, const std::vector<Effect>& effects, std::size_t recording) const;

  /// What another plant with effects adds along the motion, as torques of the nominal's joints (samples x joints); dry
  /// friction holds what it has to while a joint rests.
  Eigen::MatrixXd torque(const Plant& other, const std::vector<Effect>& effects, std::size_t recording) const;

  /// Any torque in one joint as a function of its state, in the midst of each step.
  Eigen::MatrixXd acceleration(const Eigen::VectorXd& torque, int joint, std::size_t recording) const;

  /// Whether any joint rests for a while.
  bool rests() const { return rests_; }

  /// RMS acceleration that the nominal's torques stand for: the measure of priors.
  double nominal_acceleration() const { return nominal_acceleration_; }

  const std::vector<Measured>& data() const { return data_; }
  const std::vector<Trajectory>& paths() const { return paths_; }
  const Plant& plant() const { return plant_; }

 private:
  struct Point {
    double time;
    JointVector q, v, sd_v, qdd, u, external, nominal;
    JointVector held;  // missing torque of joints at rest, else 0
    std::array<bool, kMaxJoints> rests{};
    JointMatrix mobility;
  };
  /// Of one joint, point by point: what effects look at, which way it slides, and what a torque adds to the
  /// accelerations.
  struct Along {
    std::vector<JointState> states;
    std::vector<double> direction;  // -1 to 1, less sure the slower it is; 0 where it rests
    Eigen::MatrixXd mobility;       // joints x points
    InputSpread spread;             // of its input, by samples,
    std::vector<double> gain;       // and what one more of it does, as torque; empty: as much
  };
  JointState loaded(std::size_t recording, int joint, std::size_t point, const std::vector<Effect>& beside) const;
  Eigen::MatrixXd driven(const std::vector<Effect>& effects, int joint, std::size_t recording) const;

  Plant plant_;
  const std::vector<Measured>& data_;
  const std::vector<Trajectory>& paths_;
  int joints_;
  std::size_t parts_ = 1;                           // of a step
  std::vector<std::vector<Point>> points_;          // per recording, parts_ per step
  std::vector<std::vector<Along>> along_;           // per recording and joint
  std::vector<Restarts> restarts_;                  // per recording
  std::vector<Eigen::MatrixXd> nominal_;            // per recording: mean acceleration from sample to sample
  std::vector<std::vector<Eigen::Index>> resting_;  // per recording: steps in which a joint rests
  double nominal_acceleration_ = 0.0;
  bool rests_ = false;
};

}  // namespace bayesctrl
