#pragma once

#include <functional>

#include "base/vector.hpp"
#include "physics/effect.hpp"

namespace bayesctrl {

/// Torques of an effect with a hidden state along a known motion of its joint: the state, 0 before the first call,
/// settles for `period` seconds with each, and the torque is that in the midst of them.
inline std::function<double(const JointState&)> hidden_torque(const EffectForm& form, double period) {
  const HiddenVector rest = HiddenVector::Zero(form.law().hidden_count);
  return [form, period, z = rest](const JointState& joint) mutable {
    const HiddenVector before = z;
    form.settle({z.data(), z.data() + z.size()}, joint, period);
    const HiddenVector middle = 0.5 * (before + z);
    return form.torque_of({middle.data(), middle.data() + middle.size()}, joint);
  };
}

}  // namespace bayesctrl
