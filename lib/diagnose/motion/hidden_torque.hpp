#pragma once

#include <functional>

#include "physics/effect.hpp"

namespace bayesctrl {

/// Torques of an effect with a hidden state along a known motion of its joint: the state, 0 before the first call,
/// settles for `period` seconds with each, and the torque is that in the midst of them.
template <HiddenStateEffect E>
std::function<double(const JointState&)> hidden_torque(const E& form, double period) {
  return [form, period, z = typename E::State{}](const JointState& joint) mutable {
    const typename E::State before = z;
    z = settled(form, z, joint, period);
    typename E::State middle;
    for (std::size_t i = 0; i < z.size(); ++i) middle[i] = 0.5 * (before[i] + z[i]);
    return form.torque_of(middle, joint);
  };
}

}  // namespace bayesctrl
