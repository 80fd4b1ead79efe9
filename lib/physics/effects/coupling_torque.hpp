#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -stiffness (q - q of the coupled joint): the next joint or, for the last, the one before.
struct CouplingTorque {
  static constexpr std::string_view kName = "coupling_torque";
  static constexpr std::string_view kEquation = "torque -= {stiffness} (q - q of the neighbouring joint)";
  static constexpr std::string_view kText =
      "a belt, cable or gear that pulls this joint towards the position of its neighbour";
  static constexpr int kLeastJoints = 2;
  double stiffness = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "k", kRequired});
  }

  double torque_at(const JointState& s) const { return -stiffness * (s.position - s.neighbour); }

  static std::vector<Shape<CouplingTorque>> shapes(const OperatingRange& s) {
    if (s.joints < kLeastJoints) return {};
    return {{{{1.0}}, 1}};
  }
  static CouplingTorque combined(const Shape<CouplingTorque>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static CouplingTorque drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.torque / s.range}; }

  bool operator==(const CouplingTorque&) const = default;
};

}  // namespace bayesctrl
