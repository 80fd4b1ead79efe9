#pragma once

#include <cmath>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -coefficient exp(-t / time_constant) v: what cold grease adds to a drag.
struct WarmingFriction {
  static constexpr std::string_view kName = "warming_friction";
  static constexpr std::string_view kEquation = "torque -= {coefficient} exp(-t/{time_constant}) v";
  static constexpr std::string_view kText = "drag that fades while the machine warms up after its start";
  static constexpr bool kOfTime = true;
  static constexpr bool kOnDemand = true;  // recordings seldom begin with a cold machine
  double coefficient = 0.1;
  double time_constant = 10.0;

  static void fields(auto& self, auto&& field) {
    field("coefficient", self.coefficient,
          {kPositive, "N m s/rad", "of the cold machine, beside that of the warm one", kRequired});
    field("time_constant", self.time_constant,
          {kPositive, "s", "after which it has fallen to 37 %", kRequired, {.deviation = {1.0, Measure::duration}}});
  }

  double torque_at(const JointState& s) const { return -coefficient * std::exp(-s.time / time_constant) * s.velocity; }

  static std::vector<Shape<WarmingFriction>> shapes(const OperatingRange& s) {
    std::vector<Shape<WarmingFriction>> list;
    double longest = 0.0;
    for (const double duration : s.durations) longest = std::max(longest, duration);
    for (const double time : spread(0.05 * longest, 2.0 * longest, 8)) list.push_back({{{1.0, time}}, 1});
    return list;
  }
  static WarmingFriction combined(const Shape<WarmingFriction>& shape, std::span<const double> c) {
    return {c[0], shape.members[0].time_constant};
  }
  static WarmingFriction drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque / s.speed, uniform(0.2, 0.6) * s.duration};
  }

  bool operator==(const WarmingFriction&) const = default;
};

}  // namespace bayesctrl
