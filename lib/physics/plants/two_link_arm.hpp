#pragma once

#include <cmath>

#include "physics/affine.hpp"

namespace bayesctrl {

/// Planar arm with both joints driven: M(q) q'' + C(q, q') + G(q) + friction q' = u. q1 from hanging down, q2 relative
/// to link 1 (Spong, Hutchinson & Vidyasagar, Robot Modeling and Control, two-link manipulator). Inertias are about the
/// joint's own axis. Rotors of inertia J behind gears of ratio n add (n^2 + 1) J, -n J, n^2 J to M11, M12, M22.
struct TwoLinkArm {
  static constexpr std::string_view kName = "two_link_arm";
  static constexpr std::string_view kText =
      "planar arm, both joints driven; q1 from hanging down, q2 relative to link 1";
  static constexpr std::string_view kPositionUnit = "rad", kInputUnit = "N m";
  static constexpr std::string_view kEquation = "M(q) q'' + C(q, v) v + G(q) + friction v = u, rotors adding to M";
  static constexpr int kJoints = 2;
  double mass1 = 1.0, mass2 = 1.0;
  double length1 = 1.0, length2 = 1.0;
  double com1 = 0.5, com2 = 0.5;
  double inertia1 = 1.0 / 3.0, inertia2 = 1.0 / 3.0;
  double friction1 = 0.0, friction2 = 0.0;
  double rotor_inertia = 0.0;
  double gear_ratio = 1.0;
  double gravity = 9.81;

  static void fields(auto& self, auto&& field) {
    field("mass1", self.mass1, {kPositive, "kg", "mass of link 1"});
    field("mass2", self.mass2, {kPositive, "kg", "mass of link 2"});
    field("length1", self.length1, {kPositive, "m", "joint 1 to joint 2"});
    field("length2", self.length2, {kPositive, "m", "joint 2 to tip"});
    field("com1", self.com1, {kPositive, "m", "joint 1 to the centre of mass of link 1"});
    field("com2", self.com2, {kPositive, "m", "joint 2 to the centre of mass of link 2"});
    field("inertia1", self.inertia1, {kPositive, "kg m^2", "of link 1 about the axis of joint 1"});
    field("inertia2", self.inertia2, {kPositive, "kg m^2", "of link 2 about the axis of joint 2"});
    field("friction1", self.friction1, {kNonNegative, "N m s/rad", "viscous friction in joint 1"});
    field("friction2", self.friction2, {kNonNegative, "N m s/rad", "viscous friction in joint 2"});
    field("rotor_inertia", self.rotor_inertia, {kNonNegative, "kg m^2", "of each motor's rotor"});
    field("gear_ratio", self.gear_ratio, {kPositive, "", "rotor turns per turn of the joint"});
    field("gravity", self.gravity, {kAny, "m/s^2", "acceleration of gravity"});
  }

  Affine affine(const JointVector& q, const JointVector& v) const {
    const double coupling = mass2 * length1 * com2;
    const double m11 = inertia1 + inertia2 + mass2 * length1 * length1 + 2.0 * coupling * std::cos(q[1]) +
                       (gear_ratio * gear_ratio + 1.0) * rotor_inertia;
    const double m12 = inertia2 + coupling * std::cos(q[1]) - gear_ratio * rotor_inertia;
    const double m22 = inertia2 + gear_ratio * gear_ratio * rotor_inertia;
    const double h = coupling * std::sin(q[1]);
    const double g2 = mass2 * gravity * com2 * std::sin(q[0] + q[1]);
    const double g1 = (mass1 * com1 + mass2 * length1) * gravity * std::sin(q[0]) + g2;
    const double torque1 = h * v[1] * (2.0 * v[0] + v[1]) - g1 - friction1 * v[0];
    const double torque2 = -h * v[0] * v[0] - g2 - friction2 * v[1];

    const double determinant = m11 * m22 - m12 * m12;
    Affine result{JointVector(2), JointMatrix(2, 2)};
    result.gain << m22 / determinant, -m12 / determinant, -m12 / determinant, m11 / determinant;
    result.drift << result.gain(0, 0) * torque1 + result.gain(0, 1) * torque2,
        result.gain(1, 0) * torque1 + result.gain(1, 1) * torque2;
    return result;
  }

  bool operator==(const TwoLinkArm&) const = default;
};

}  // namespace bayesctrl
