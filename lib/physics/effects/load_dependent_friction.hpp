#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Dry friction -k |tau_in - tau_ext| sign v; at rest it holds up to that level.
struct LoadDependentFriction {
  static constexpr std::string_view kName = "load_dependent_friction";
  static constexpr std::string_view kEquation = "torque -= {k} |tau_in - tau_ext| sign(v)";
  static constexpr std::string_view kText = "dry friction that grows with the load on gears and bearings";
  static constexpr bool kFeelsLoad = true;
  double k = 0.05;

  static void fields(auto& self, auto&& field) {
    field("k", self.k,
          {Range{.low = 0.0, .high = 1.0, .low_open = true, .high_open = true}, "", "share of the load", kRequired,
           kAnyAdmitted});
  }

  /// Magnitude while sliding, and the largest torque that it resists at rest.
  double sliding(const JointState& s) const { return k * s.load(); }
  double holding(const JointState& s) const { return sliding(s); }

  static std::vector<Shape<LoadDependentFriction>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static LoadDependentFriction combined(const Shape<LoadDependentFriction>& /*shape*/, std::span<const double> c) {
    return {c[0]};
  }
  static LoadDependentFriction drawn(auto&& /*uniform*/, const DrawScales& s) { return {std::min(s.strength, 0.9)}; }

  bool operator==(const LoadDependentFriction&) const = default;
};

}  // namespace bayesctrl
