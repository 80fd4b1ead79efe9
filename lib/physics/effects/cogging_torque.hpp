#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque amplitude sin(order q + phase).
struct CoggingTorque {
  static constexpr std::string_view kName = "cogging_torque";
  static constexpr std::string_view kText =
      "a torque that pulses with the rotor's position, from magnets or gear teeth";
  double amplitude = 0.1;
  double order = 6.0;
  double phase = 0.0;

  static void fields(auto& self, auto&& field) {
    field("amplitude", self.amplitude, {kPositive, "N m", "of the pulsation", kRequired});
    field("order", self.order, {between(2.0, 30.0), "", "pulses per turn", kRequired});
    field("phase", self.phase, {kAny, "rad", "at q = 0", kRequired});
  }

  double torque_at(const JointState& s) const { return amplitude * std::sin(order * s.position + phase); }

  bool operator==(const CoggingTorque&) const = default;
};

}  // namespace bayesctrl
