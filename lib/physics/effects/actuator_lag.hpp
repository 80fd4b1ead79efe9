#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// First-order lag: time_constant z' = u - z.
struct ActuatorLag {
  static constexpr std::string_view kName = "actuator_lag";
  static constexpr std::string_view kEquation = "{time_constant} u' = u_in - u";
  static constexpr std::string_view kText = "the motor takes time to build up its torque";
  double time_constant = 0.01;

  static void fields(auto& self, auto&& field) {
    field("time_constant", self.time_constant, {between(0.001, 0.5), "s", "of the lag", kRequired, kAnyAdmitted});
  }

  double lag() const { return time_constant; }

  static std::vector<Shape<ActuatorLag>> shapes(const OperatingRange& /*s*/) {
    std::vector<Shape<ActuatorLag>> list;
    for (const double tried : spread(0.001, 0.5, 14)) list.push_back({{{tried}}, 1});
    return list;
  }
  static ActuatorLag combined(const Shape<ActuatorLag>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].time_constant};
  }
  static ActuatorLag drawn(auto&& /*uniform*/, const DrawScales& s) { return {std::clamp(s.strength, 0.001, 0.5)}; }

  bool operator==(const ActuatorLag&) const = default;
};

}  // namespace bayesctrl
