#pragma once

#include <Eigen/Core>

namespace bayesctrl {

/// Most joints, and most inputs, of a machine. Vectors below live on the stack: the control step allocates nothing.
inline constexpr int kMaxJoints = 4;

/// One value per joint or per input.
using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxJoints, 1>;

/// Joints x inputs.
using JointMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMaxJoints, kMaxJoints>;

/// The same with a slot for every joint that a machine may have, 0 beyond its own.
using JointSlots = Eigen::Matrix<double, kMaxJoints, 1>;

/// The same where the number of joints is a constant.
template <int kJoints>
using Joints = Eigen::Matrix<double, kJoints, 1>;
template <int kJoints>
using JointsSquare = Eigen::Matrix<double, kJoints, kJoints>;

/// Positions, then velocities: the x = [q, v] of the paper.
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 2 * kMaxJoints, 1>;

}  // namespace bayesctrl
