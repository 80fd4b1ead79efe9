#pragma once

#include "physics/affine.hpp"

namespace bayesctrl {

/// m q'' = u - friction q': a slide driven by a force, or a bare rotor driven by a torque.
struct Mass {
  static constexpr std::string_view kName = "mass";
  static constexpr std::string_view kText = "a slide driven by a force, or a bare rotor driven by a torque";
  static constexpr std::string_view kPositionUnit = "m", kInputUnit = "N";
  static constexpr std::string_view kEquation = "{mass} q'' = u - {friction} v";
  static constexpr int kJoints = 1;
  double mass = 1.0;
  double friction = 0.0;

  static void fields(auto& self, auto&& field) {
    field("mass", self.mass, {kPositive, "kg", "moving mass, or inertia in kg m^2"});
    field("friction", self.friction, {kNonNegative, "N s/m", "viscous friction"});
  }

  AffineOf<1> affine(const Joints<1>& /*q*/, const Joints<1>& v) const {
    return AffineOf<1>::scalar(-friction / mass * v[0], 1.0 / mass);
  }

  bool operator==(const Mass&) const = default;
};

}  // namespace bayesctrl
