#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque amplitude sin(frequency t + phase).
struct PeriodicDisturbance {
  static constexpr std::string_view kName = "periodic_disturbance";
  static constexpr std::string_view kText = "a shaking from outside at a fixed frequency";
  double amplitude = 0.1;
  double frequency = 6.0;
  double phase = 0.0;

  static void fields(auto& self, auto&& field) {
    field("amplitude", self.amplitude, {kPositive, "N m", "of the disturbance", kRequired});
    field("frequency", self.frequency, {kPositive, "rad/s", "below half the sampling rate", kRequired});
    field("phase", self.phase, {kAny, "rad", "at the start of each recording", kRequired});
  }

  double torque_at(const JointState& s) const { return amplitude * std::sin(frequency * s.time + phase); }

  bool operator==(const PeriodicDisturbance&) const = default;
};

}  // namespace bayesctrl
