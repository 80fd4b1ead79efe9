#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// A constant torque.
struct ConstantBias {
  static constexpr std::string_view kName = "constant_bias";
  static constexpr std::string_view kEquation = "torque += {torque}";
  static constexpr std::string_view kText =
      "a constant pull to one side, from a cable, an imbalance or an amplifier offset";
  double torque = 0.1;

  static void fields(auto& self, auto&& field) { field("torque", self.torque, {kAny, "N m", "along q", kRequired}); }

  double torque_at(const JointState& /*s*/) const { return torque; }

  static std::vector<Shape<ConstantBias>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}}}; }
  static ConstantBias combined(const Shape<ConstantBias>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static ConstantBias drawn(auto&& uniform, const DrawScales& s) {
    return {drawn_sign(uniform) * s.strength * s.torque};
  }

  bool operator==(const ConstantBias&) const = default;
};

}  // namespace bayesctrl
