#pragma once

#include <Eigen/Core>
#include <span>

namespace bayesctrl {

/// Most joints, and most inputs, of a machine. Vectors below live on the stack: the control step allocates nothing.
inline constexpr int kMaxJoints = 7;

/// One value per joint or per input; the number of joints may be a constant.
template <int kJoints>
using Joints = Eigen::Matrix<double, kJoints, 1, Eigen::ColMajor, kJoints == Eigen::Dynamic ? kMaxJoints : kJoints, 1>;
using JointVector = Joints<Eigen::Dynamic>;

/// Joints x inputs.
template <int kJoints>
using JointsSquare =
    Eigen::Matrix<double, kJoints, kJoints, Eigen::ColMajor, kJoints == Eigen::Dynamic ? kMaxJoints : kJoints,
                  kJoints == Eigen::Dynamic ? kMaxJoints : kJoints>;
using JointMatrix = JointsSquare<Eigen::Dynamic>;

/// With a slot for every joint that a machine may have, 0 beyond its own.
using JointSlots = Joints<kMaxJoints>;

/// Most numbers of the hidden states of a machine's effects; one value for each.
inline constexpr int kMaxHidden = 16;
using HiddenVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxHidden, 1>;

/// Positions, then velocities: the x = [q, v] of the paper.
using StateVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 2 * kMaxJoints, 1>;

/// A view of a vector of any type; no copy that it could outlive.
template <class Derived>
std::span<const double> span_of(const Eigen::PlainObjectBase<Derived>& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

}  // namespace bayesctrl
