#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Dry friction: -level sign v while sliding; at rest it holds while the other torques stay within level.
struct CoulombFriction {
  static constexpr std::string_view kName = "coulomb_friction";
  static constexpr std::string_view kEquation = "torque -= {level} sign(v)";
  static constexpr std::string_view kText =
      "dry friction of the same strength at any speed; the joint sticks when pushed too gently";
  double level = 0.1;

  static void fields(auto& self, auto&& field) {
    field("level", self.level, {kPositive, "N m", "torque of the friction", kRequired});
  }

  /// Magnitude while sliding, and the largest torque that it resists at rest.
  double sliding(const JointState& /*s*/) const { return level; }
  double holding(const JointState& /*s*/) const { return level; }

  CoulombFriction scaled(double by) const { return {by * level}; }

  static std::vector<Shape<CoulombFriction>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static CoulombFriction combined(const Shape<CoulombFriction>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static CoulombFriction drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.torque}; }

  bool operator==(const CoulombFriction&) const = default;
};

}  // namespace bayesctrl
