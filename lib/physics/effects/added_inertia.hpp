#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -inertia q''.
struct AddedInertia {
  static constexpr std::string_view kName = "added_inertia";
  static constexpr std::string_view kEquation = "torque -= {inertia} q''";
  static constexpr std::string_view kText = "more inertia than the model has, as from a payload or a rotor";
  double inertia = 0.1;

  static void fields(auto& self, auto&& field) {
    field("inertia", self.inertia, {kPositive, "kg m^2", "added to the joint", kRequired});
  }

  double added_inertia() const { return inertia; }

  static std::vector<Shape<AddedInertia>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 1}}; }
  static AddedInertia combined(const Shape<AddedInertia>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static AddedInertia drawn(auto&& /*uniform*/, const DrawScales& s) {
    return {s.strength * s.torque / (10.0 * s.range)};
  }

  bool operator==(const AddedInertia&) const = default;
};

}  // namespace bayesctrl
