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
inline std::span<const double> part_of(const HiddenVector& all, const EffectForm& form, int slot) {
  return {all.data() + slot, static_cast<std::size_t>(form.law().hidden_count)};
}
inline std::span<double> part_of(HiddenVector& all, const EffectForm& form, int slot) {
  return {all.data() + slot, static_cast<std::size_t>(form.law().hidden_count)};
}

/// One stage of a Runge-Kutta step of one hidden state: `next` is `begin` after `by` seconds in which `joint` drives
/// it. One that can say how it settles does so, any other moves along its rate where it stands `at`, which goes to
/// `rates`. With nothing in `at` it moves along `rates`, their mean over the step.
inline void follow_one(const EffectForm& form, int slot, const JointState& joint, const HiddenVector& begin,
                       const HiddenVector& at, double by, HiddenVector& rates, HiddenVector& next) {
  const int count = form.law().hidden_count;
  next.segment(slot, count) = begin.segment(slot, count);
  if (form.roles().settles) return form.settle(part_of(next, form, slot), joint, by);
  if (at.size() > 0) form.rate(part_of(at, form, slot), joint, part_of(rates, form, slot));
  next.segment(slot, count) += by * rates.segment(slot, count);
}

/// Where in time and in which regime the machine is: direction of sliding (0: stuck) of each joint with dry friction,
/// the segment of each drive, and how far the lags' outputs are from what the drives say.
struct Machine::Moment {
  double t = 0.0;
  const std::vector<Drive>* drives = nullptr;
  std::array<std::size_t, kMaxJoints> segment{};
  std::array<int, kMaxJoints> direction{};
  std::vector<char> touched;                  // of each effect: whether its contact acts in this step
  double begin = 0.0;                         // when the lags departed
  JointSlots departure = JointSlots::Zero();  // by how much, then
  Remainder::Memory memory;

  bool touches(std::size_t effect) const { return effect < touched.size() && touched[effect] != 0; }
};

/// With a slot for every joint that a machine may have.
inline JointSlots padded(const JointVector& values) {
  JointSlots slots = JointSlots::Zero();
  for (Eigen::Index j = 0; j < values.size(); ++j) slots[j] = values[j];
  return slots;
}

}  // namespace bayesctrl
