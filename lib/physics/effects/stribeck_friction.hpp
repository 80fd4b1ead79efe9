#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Dry friction -(coulomb + (static - coulomb) exp(-(v/velocity)^2)) sign v; sticks at static_level.
struct StribeckFriction {
  static constexpr std::string_view kName = "stribeck_friction";
  static constexpr std::string_view kText =
      "dry friction that is stronger at rest than in motion, so that slow motion sticks and slips";
  double coulomb = 0.1;
  double static_level = 0.2;
  double velocity = 0.1;

  static void fields(auto& self, auto&& field) {
    field("coulomb", self.coulomb, {kPositive, "N m", "friction at speed", kRequired});
    field("static", self.static_level, {kPositive, "N m", "friction at rest", kRequired});
    field("velocity", self.velocity, {between(0.01, 1.0), "rad/s", "speed at which it falls off", kRequired});
  }

  std::string problem() const { return static_level >= coulomb ? "" : "static must be at least coulomb"; }

  /// Magnitude while sliding, and the largest torque that it resists at rest.
  double sliding(const JointState& s) const {
    const double ratio = s.velocity / velocity;
    return coulomb + (static_level - coulomb) * std::exp(-ratio * ratio);
  }
  double holding(const JointState& /*s*/) const { return static_level; }

  bool operator==(const StribeckFriction&) const = default;
};

}  // namespace bayesctrl
