#pragma once

#include "physics/machine/machine.hpp"

namespace bayesctrl {

/// [q, v], and one hidden state per joint (presliding).
template <int kJoints>
struct Machine::StateOf {
  Joints<kJoints> q, v, z;
};

/// Where in time and in which regime the machine is: direction of sliding (0: stuck) of each joint with dry friction,
/// the segment of each drive, and how far the lags' outputs are from what the drives say.
struct Machine::Moment {
  double t = 0.0;
  const std::vector<Drive>* drives = nullptr;
  std::array<std::size_t, kMaxJoints> segment{};
  std::array<int, kMaxJoints> direction{};
  double begin = 0.0;                         // when the lags departed
  JointSlots departure = JointSlots::Zero();  // by how much, then
  Remainder::Memory memory;
};

/// With a slot for every joint that a machine may have.
inline JointSlots padded(const JointVector& values) {
  JointSlots slots = JointSlots::Zero();
  for (Eigen::Index j = 0; j < values.size(); ++j) slots[j] = values[j];
  return slots;
}

}  // namespace bayesctrl
