#pragma once

#include <string>
#include <vector>

#include "physics/affine.hpp"

namespace bayesctrl {

/// Planar chain of links, every joint driven: M(q) q'' + C(q, q') q' + G(q) + friction q' = u. q1 from hanging down,
/// the others relative to the link before. Inertias are about the joint's own axis, as in `TwoLinkArm`; rotors add
/// their inertia, as the joint feels it through its gear, to the diagonal of M. Lists are one for all links or one for
/// each; `length` says how many there are.
struct PlanarArm {
  static constexpr std::string_view kName = "planar_arm";
  static constexpr std::string_view kText = "planar chain of links, all joints driven; q1 from hanging down";
  static constexpr std::string_view kPositionUnit = "rad", kInputUnit = "N m";
  static constexpr std::string_view kEquation =
      "M(q) q'' + C(q, v) v + G(q) + friction v = u, rotors adding to the diagonal of M";
  std::vector<double> length{0.5, 0.5, 0.5};
  std::vector<double> mass{1.0};
  std::vector<double> com{0.25};
  std::vector<double> inertia{0.1};
  std::vector<double> friction{0.0};
  std::vector<double> rotor_inertia{0.0};
  double gravity = 9.81;

  static void fields(auto& self, auto&& field) {
    field("length", self.length, {kPositive, "m", "joint to joint, and to the tip, of each link"});
    field("mass", self.mass, {kPositive, "kg", "of the links"});
    field("com", self.com, {kPositive, "m", "joint to the link's centre of mass"});
    field("inertia", self.inertia, {kPositive, "kg m^2", "of a link about its joint's axis"});
    field("friction", self.friction, {kNonNegative, "N m s/rad", "viscous friction in the joints"});
    field("rotor_inertia", self.rotor_inertia,
          {kNonNegative, "kg m^2", "of the motors, as the joints feel it: gear ratio squared times the rotor's"});
    field("gravity", self.gravity, {kAny, "m/s^2", "acceleration of gravity"});
  }

  std::string problem() const;

  int joint_count() const { return static_cast<int>(length.size()); }
  Affine affine(const JointVector& q, const JointVector& v) const;

  /// Torque of gravity along q.
  JointVector external_torque(const JointVector& q) const;

  bool operator==(const PlanarArm&) const = default;
};

}  // namespace bayesctrl
