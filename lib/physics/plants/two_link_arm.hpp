#pragma once

#include <cmath>
#include <string>

#include "base/format.hpp"
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

  std::string problem() const {
    // The determinant of M is concave in cos q2: it is smallest where the arm is straight or folded.
    const double coupling = mass2 * length1 * com2;
    const double rotor1 = (gear_ratio * gear_ratio + 1.0) * rotor_inertia;
    const double rotor2 = gear_ratio * gear_ratio * rotor_inertia;
    for (const double side : {coupling, -coupling}) {
      const double m11 = inertia1 + inertia2 + mass2 * length1 * length1 + 2.0 * side + rotor1;
      const double m12 = inertia2 + side - gear_ratio * rotor_inertia, m22 = inertia2 + rotor2;
      if (m11 * m22 > m12 * m12) continue;
      return "no arm has these inertias: they are about the joints, and so at least mass com^2 (" +
             format(mass1 * com1 * com1, 4) + " and " + format(mass2 * com2 * com2, 4) + ")";
    }
    return "";
  }

  AffineOf<2> affine(const Joints<2>& q, const Joints<2>& v) const {
    const double coupling = mass2 * length1 * com2, sin2 = std::sin(q[1]), cos2 = std::cos(q[1]);
    const double m11 = inertia1 + inertia2 + mass2 * length1 * length1 + 2.0 * coupling * cos2 +
                       (gear_ratio * gear_ratio + 1.0) * rotor_inertia;
    const double m12 = inertia2 + coupling * cos2 - gear_ratio * rotor_inertia;
    const double m22 = inertia2 + gear_ratio * gear_ratio * rotor_inertia;
    const double h = coupling * sin2;
    const Joints<2> external = external_torque(q[0], sin2, cos2);
    const double torque1 = h * v[1] * (2.0 * v[0] + v[1]) + external[0] - friction1 * v[0];
    const double torque2 = -h * v[0] * v[0] + external[1] - friction2 * v[1];

    const double scale = 1.0 / (m11 * m22 - m12 * m12);
    const double gain11 = scale * m22, gain12 = -scale * m12, gain22 = scale * m11;
    AffineOf<2> result;
    result.drift[0] = gain11 * torque1 + gain12 * torque2;
    result.drift[1] = gain12 * torque1 + gain22 * torque2;
    result.gain(0, 0) = gain11;
    result.gain(0, 1) = result.gain(1, 0) = gain12;
    result.gain(1, 1) = gain22;
    return result;
  }

  /// Torque of gravity along q.
  Joints<2> external_torque(const Joints<2>& q) const { return external_torque(q[0], std::sin(q[1]), std::cos(q[1])); }

  bool operator==(const TwoLinkArm&) const = default;

 private:
  Joints<2> external_torque(double q1, double sin2, double cos2) const {
    const double sin1 = std::sin(q1), of_link2 = -mass2 * gravity * com2 * (sin1 * cos2 + std::cos(q1) * sin2);
    return {of_link2 - (mass1 * com1 + mass2 * length1) * gravity * sin1, of_link2};
  }
};

}  // namespace bayesctrl
