#pragma once

#include <numbers>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -amplitude cos(q - centre) v, the part of the paper's r(x1) that varies; total friction stays >= 0.
struct PositionDependentFriction {
  static constexpr std::string_view kName = "position_dependent_friction";
  static constexpr std::string_view kEquation = "torque -= {amplitude} cos(q - {centre}) v";
  static constexpr std::string_view kText = "drag that depends on where the joint stands, as from a bent shaft";
  static constexpr bool kNeedsTurning = true;
  double amplitude = 0.1;
  double centre = 0.0;

  static void fields(auto& self, auto&& field) {
    field("amplitude", self.amplitude, {kPositive, "N m s/rad", "of the variation", kRequired});
    field("centre", self.centre, {kAny, "rad", "position of the largest friction", kRequired, kAngle});
  }

  double torque_at(const JointState& s) const { return -amplitude * std::cos(s.position - centre) * s.velocity; }

  /// Drag that the plant must have itself, for the sum to be friction everywhere.
  double least_drag() const { return amplitude; }

  static std::vector<Shape<PositionDependentFriction>> shapes(const OperatingRange& /*s*/) {
    return {{{{1.0, 0.0}, {1.0, std::numbers::pi / 2.0}}}};
  }
  static PositionDependentFriction combined(const Shape<PositionDependentFriction>& /*shape*/,
                                            std::span<const double> c) {
    return {std::hypot(c[0], c[1]), std::atan2(c[1], c[0])};
  }
  static PositionDependentFriction drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque / s.speed, uniform(-1.5, 1.5)};
  }

  bool operator==(const PositionDependentFriction&) const = default;
};

}  // namespace bayesctrl
