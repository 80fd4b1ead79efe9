#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -stiffness q.
struct LinearSpring {
  static constexpr std::string_view kName = "linear_spring";
  static constexpr std::string_view kEquation = "torque -= {stiffness} q";
  static constexpr std::string_view kText = "a spring, cable or hose that pulls back in step with the displacement";
  static constexpr bool kSpring = true;
  double stiffness = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "k", kRequired});
  }

  double torque_at(const JointState& s) const { return -stiffness * s.position; }

  static std::vector<Shape<LinearSpring>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static LinearSpring combined(const Shape<LinearSpring>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static LinearSpring drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.torque / s.range}; }

  bool operator==(const LinearSpring&) const = default;
};

}  // namespace bayesctrl
