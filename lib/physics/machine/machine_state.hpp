#pragma once

#include "physics/machine/machine.hpp"

namespace bayesctrl {

/// [q, v], and the hidden states of the effects.
template <int kJoints>
struct Machine::StateOf {
  Joints<kJoints> q, v;
  HiddenVector z;
};

/// The hidden state of one effect among those of all.
template <HiddenStateEffect E>
typename E::State taken(const HiddenVector& all, int slot) {
  typename E::State z;
  for (std::size_t i = 0; i < z.size(); ++i) z[i] = all[slot + static_cast<Eigen::Index>(i)];
  return z;
}
template <std::size_t kCount>
void put(HiddenVector& all, int slot, const HiddenState<kCount>& z) {
  for (std::size_t i = 0; i < kCount; ++i) all[slot + static_cast<Eigen::Index>(i)] = z[i];
}

/// One stage of a Runge-Kutta step of one hidden state: `next` is `begin` after `by` seconds in which `joint` drives
/// it. One that can say how it settles does so, any other moves along its rate where it stands `at`, which goes to
/// `rates`. With nothing in `at` it moves along `rates`, their mean over the step.
template <HiddenStateEffect E>
void follow_one(const E& form, int slot, const JointState& joint, const HiddenVector& begin, const HiddenVector& at,
                double by, HiddenVector& rates, HiddenVector& next) {
  const typename E::State z = taken<E>(begin, slot);
  if constexpr (SolvedStateEffect<E>) {
    put(next, slot, settled(form, z, joint, by));
  } else {
    if (at.size() > 0) put(rates, slot, form.rate(taken<E>(at, slot), joint));
    put(next, slot, moved(z, taken<E>(rates, slot), by));
  }
}

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
