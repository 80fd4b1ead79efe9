#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// measured = true + angle.
struct SensorOffset {
  static constexpr std::string_view kName = "sensor_offset";
  static constexpr std::string_view kEquation = "measured = q + {angle}";
  static constexpr std::string_view kText = "the position sensor is mounted or zeroed with an offset";
  static constexpr bool kNeedsTurning = true;
  double angle = 0.05;

  static void fields(auto& self, auto&& field) {
    field("angle", self.angle, {between(-0.5, 0.5), "rad", "of the sensor", kRequired});
  }

  double measured(double position) const { return position + angle; }

  static std::vector<Shape<SensorOffset>> shapes(const OperatingRange& /*s*/) { return {{{{1.0}}, 0, -1, -0.5, 0.5}}; }
  static SensorOffset combined(const Shape<SensorOffset>& /*shape*/, std::span<const double> c) { return {c[0]}; }
  static SensorOffset drawn(auto&& uniform, const DrawScales& s) {
    return {drawn_sign(uniform) * std::min(s.strength, 0.5)};
  }

  bool operator==(const SensorOffset&) const = default;
};

}  // namespace bayesctrl
