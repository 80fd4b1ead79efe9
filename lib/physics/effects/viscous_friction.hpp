#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -coefficient v, beside the plant's own friction.
struct ViscousFriction {
  static constexpr std::string_view kName = "viscous_friction";
  static constexpr std::string_view kEquation = "torque -= {coefficient} v";
  static constexpr std::string_view kText = "grease or bearing drag that grows in step with speed";
  double coefficient = 0.1;

  static void fields(auto& self, auto&& field) {
    field("coefficient", self.coefficient, {kPositive, "N m s/rad", "c", kRequired});
  }

  double torque_at(const JointState& s) const { return -coefficient * s.velocity; }

  static std::vector<Shape<ViscousFriction>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static ViscousFriction combined(const Shape<ViscousFriction>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static ViscousFriction drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.torque / s.speed}; }

  bool operator==(const ViscousFriction&) const = default;
};

}  // namespace bayesctrl
