#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -coefficient v |v|.
struct QuadraticDrag {
  static constexpr std::string_view kName = "quadratic_drag";
  static constexpr std::string_view kEquation = "torque -= {coefficient} v |v|";
  static constexpr std::string_view kText = "air or fluid drag that grows with the square of speed";
  double coefficient = 0.1;

  static void fields(auto& self, auto&& field) {
    field("coefficient", self.coefficient, {kPositive, "N m s^2/rad^2", "c", kRequired});
  }

  double torque_at(const JointState& s) const { return -coefficient * s.velocity * std::abs(s.velocity); }

  static std::vector<Shape<QuadraticDrag>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static QuadraticDrag combined(const Shape<QuadraticDrag>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static QuadraticDrag drawn(auto&& /*uniform*/, const DrawScales& s) {
    return {s.strength * s.torque / (s.speed * s.speed)};
  }

  bool operator==(const QuadraticDrag&) const = default;
};

}  // namespace bayesctrl
