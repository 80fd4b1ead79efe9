#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// A constant torque from time on.
struct TorqueStep {
  static constexpr std::string_view kName = "torque_step";
  static constexpr std::string_view kText = "something changed suddenly: a part came loose or was added";
  double torque = 0.1;
  double time = 1.0;

  static void fields(auto& self, auto&& field) {
    field("torque", self.torque, {kAny, "N m", "along q", kRequired});
    field("time", self.time, {kNonNegative, "s", "since the start of the recording", kRequired});
  }

  double torque_at(const JointState& s) const { return s.time >= time ? torque : 0.0; }
  double switch_time() const { return time; }

  bool operator==(const TorqueStep&) const = default;
};

}  // namespace bayesctrl
