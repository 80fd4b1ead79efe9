#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -stiffness q^3.
struct CubicSpring {
  static constexpr std::string_view kName = "cubic_spring";
  static constexpr std::string_view kEquation = "torque -= {stiffness} q^3";
  static constexpr std::string_view kText = "a spring that hardens with displacement";
  static constexpr bool kSpring = true;
  double stiffness = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad^3", "k", kRequired});
  }

  double torque_at(const JointState& s) const { return -stiffness * s.position * s.position * s.position; }

  static std::vector<Shape<CubicSpring>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static CubicSpring combined(const Shape<CubicSpring>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static CubicSpring drawn(auto&& /*uniform*/, const DrawScales& s) {
    return {s.strength * s.torque / (s.range * s.range * s.range)};
  }

  bool operator==(const CubicSpring&) const = default;
};

}  // namespace bayesctrl
