#pragma once

#include <algorithm>
#include <cmath>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -coefficient exp(-(T - 20)/scale) v at T degrees Celsius: lubricants thin as they warm.
struct ThermalFriction {
  static constexpr std::string_view kName = "thermal_friction";
  static constexpr std::string_view kEquation = "torque -= {coefficient} exp(-(T - 20)/{scale}) v";
  static constexpr std::string_view kText = "drag that falls with the temperature T in degrees Celsius";
  static constexpr bool kFeelsTemperature = true;
  static constexpr double kLeastRange = 4.0;  // degrees that have to be passed before anything is said of it
  double coefficient = 0.1;
  double scale = 20.0;

  static void fields(auto& self, auto&& field) {
    field("coefficient", self.coefficient, {kPositive, "N m s/rad", "at 20 degrees Celsius", kRequired});
    field("scale", self.scale,
          {between(1, 1000), "degC", "by which drag falls to 37 %", kRequired, {.deviation = {50.0}, .step = {0.05}}});
  }

  double torque_at(const JointState& s) const {
    return -coefficient * std::exp((kReferenceTemperature - s.temperature) / scale) * s.velocity;
  }

  static std::vector<Shape<ThermalFriction>> shapes(const OperatingRange& s) {
    std::vector<Shape<ThermalFriction>> list;
    const double range = s.warmest - s.coldest;  // 0: temperature was not recorded, or says nothing
    if (range < kLeastRange) return list;
    for (const double scale : spread(0.3 * range, std::min(5.0 * range, 1000.0), 8)) {
      const double about = std::exp((0.5 * (s.coldest + s.warmest) - kReferenceTemperature) / scale);
      list.push_back({{{about, scale}}, 1});  // a coefficient of 1 in the middle
    }
    return list;
  }
  static ThermalFriction combined(const Shape<ThermalFriction>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].coefficient, shape.members[0].scale};
  }
  static ThermalFriction drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque / s.speed, uniform(8.0, 30.0)};
  }

  bool operator==(const ThermalFriction&) const = default;
};

}  // namespace bayesctrl
