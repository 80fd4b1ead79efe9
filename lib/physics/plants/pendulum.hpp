#pragma once

#include <cmath>

#include "physics/affine.hpp"

namespace bayesctrl {

/// The paper's pendulum: q'' = -(g/l) sin q - r(q)/(m l^2) q' + u/(m l^2), q = 0 hanging down, q = pi upright,
/// friction r(q) = friction + friction_amplitude cos(q - friction_centre).
struct Pendulum {
  static constexpr std::string_view kName = "pendulum";
  static constexpr std::string_view kText = "point mass on a rod, driven by a torque; q = 0 hangs down";
  static constexpr std::string_view kPositionUnit = "rad", kInputUnit = "N m";
  static constexpr std::string_view kEquation =
      "{mass} {length}^2 q'' = u - {mass} {gravity} {length} sin(q) - r v, "
      "r = {friction} + {friction_amplitude} cos(q - {friction_centre})";
  static constexpr int kJoints = 1;
  double length = 1.0;
  double friction = 0.0;
  double mass = 1.0;
  double gravity = 9.81;
  double friction_amplitude = 0.0;
  double friction_centre = 0.0;

  static void fields(auto& self, auto&& field) {
    field("length", self.length, {kPositive, "m", "pivot to mass"});
    field("friction", self.friction, {kNonNegative, "N m s/rad", "viscous friction r"});
    field("mass", self.mass, {kPositive, "kg", "point mass"});
    field("gravity", self.gravity, {kAny, "m/s^2", "acceleration of gravity"});
    field("friction_amplitude", self.friction_amplitude,
          {kNonNegative, "N m s/rad", "part of the friction that varies with the angle, r(q) of the paper"});
    field("friction_centre", self.friction_centre, {kAny, "rad", "angle of the largest friction"});
  }

  std::string problem() const {
    return friction_amplitude <= friction ? "" : "friction_amplitude exceeds friction: friction would turn negative";
  }

  AffineOf<1> affine(const Joints<1>& q, const Joints<1>& v) const {
    const double inertia = mass * length * length;
    const double r =
        friction_amplitude == 0.0 ? friction : friction + friction_amplitude * std::cos(q[0] - friction_centre);
    return AffineOf<1>::scalar(-gravity / length * std::sin(q[0]) - r / inertia * v[0], 1.0 / inertia);
  }

  /// Torque of gravity along q.
  Joints<1> external_torque(const Joints<1>& q) const {
    return Joints<1>::Constant(-mass * gravity * length * std::sin(q[0]));
  }

  bool operator==(const Pendulum&) const = default;
};

}  // namespace bayesctrl
