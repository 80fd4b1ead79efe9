#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include "base/fields.hpp"

namespace bayesctrl {

/// What an effect's formula may look at: one joint at one instant. SI units; for a slide read m, m/s, N.
struct JointState {
  double position = 0.0;
  double velocity = 0.0;
  double time = 0.0;             // since the start of the recording
  double motor_torque = 0.0;     // tau_in: what the input does to the joint, after the input effects
  double external_torque = 0.0;  // tau_ext: gravity and springs of the plant, along the joint
};

}  // namespace bayesctrl
