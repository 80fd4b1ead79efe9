#pragma once

#include "diagnose/motion/smoother.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// The region that the motion visits in one joint.
OperatingRange operating_range(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, int joint);

}  // namespace bayesctrl
