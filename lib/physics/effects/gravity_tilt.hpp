#pragma once

#include <algorithm>

#include "physics/effects/sensor_offset.hpp"

namespace bayesctrl {

/// Gravity acts as at q + angle: the torque tau_ext(q + angle) - tau_ext(q).
struct GravityTilt {
  static constexpr std::string_view kName = "gravity_tilt";
  static constexpr std::string_view kEquation = "gravity acts at q + {angle}";
  static constexpr std::string_view kText = "the machine stands tilted against the vertical";
  using Contains = SensorOffset;  // only the difference of the two angles moves the machine
  static constexpr bool kNeedsTurning = true;
  double angle = 0.05;

  static void fields(auto& self, auto&& field) {
    field("angle", self.angle, {between(-0.5, 0.5), "rad", "of the tilt", kRequired});
  }

  double tilt() const { return angle; }

  /// Of a pendulum the same is measured through a sensor that is off by as much the other way.
  SensorOffset equivalent() const { return {-angle}; }
  static GravityTilt equivalent_of(const SensorOffset& other) { return {-other.angle}; }

  static std::vector<Shape<GravityTilt>> shapes(const OperatingRange& /*s*/) {
    return {{{{0.01}}, 0, -1, -50.0, 50.0}};
  }
  static GravityTilt combined(const Shape<GravityTilt>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].angle};
  }
  static GravityTilt drawn(auto&& uniform, const DrawScales& s) {
    return {drawn_sign(uniform) * std::min(s.strength, 0.5)};
  }

  bool operator==(const GravityTilt&) const = default;
};

}  // namespace bayesctrl
