#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -stiffness (q - position) - damping v beyond position: above it if position >= 0, below it otherwise.
struct HardStop {
  static constexpr std::string_view kName = "hard_stop";
  static constexpr std::string_view kText = "a bumper or end stop that the joint runs into";
  double position = 1.0;
  double stiffness = 100.0;
  double damping = 1.0;

  static void fields(auto& self, auto&& field) {
    field("position", self.position, {kAny, "rad", "where it begins", kRequired});
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "of the stop", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "of the stop", kRequired});
  }

  double torque_at(const JointState& s) const {
    const double depth = s.position - position;
    const bool inside = position >= 0.0 ? depth > 0.0 : depth < 0.0;
    return inside ? -stiffness * depth - damping * s.velocity : 0.0;
  }

  bool operator==(const HardStop&) const = default;
};

}  // namespace bayesctrl
