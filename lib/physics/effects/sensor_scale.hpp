#pragma once

#include <algorithm>

#include "physics/effects/input_gain.hpp"

namespace bayesctrl {

/// measured = scale true.
struct SensorScale {
  static constexpr std::string_view kName = "sensor_scale";
  static constexpr std::string_view kEquation = "measured = {scale} q";
  static constexpr std::string_view kText = "the position sensor is calibrated with a wrong scale";
  double scale = 1.1;

  static void fields(auto& self, auto&& field) {
    field("scale", self.scale, {between(0.7, 1.4), "", "of the sensor", kRequired, {.mean = 1.0}});
  }

  double measured(double position) const { return scale * position; }

  /// Of a mass the same is measured behind a motor that is stronger by as much.
  InputGain equivalent() const { return {scale}; }
  static SensorScale equivalent_of(const InputGain& other) { return {other.gain}; }

  static std::vector<Shape<SensorScale>> shapes(const OperatingRange& /*s*/) { return {{{{2.0}}, 0, -1, -0.3, 0.4}}; }
  static SensorScale combined(const Shape<SensorScale>& /*shape*/, std::span<const double> c) { return {1.0 + c[0]}; }
  static SensorScale drawn(auto&& uniform, const DrawScales& s) {
    const double error = std::min(s.strength, 0.4);
    return {drawn_sign(uniform) < 0.0 ? 1.0 / (1.0 + error) : 1.0 + error};
  }

  bool operator==(const SensorScale&) const = default;
};

}  // namespace bayesctrl
