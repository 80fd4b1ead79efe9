#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// measured = scale true.
struct SensorScale {
  static constexpr std::string_view kName = "sensor_scale";
  static constexpr std::string_view kEquation = "measured = {scale} q";
  static constexpr std::string_view kText = "the position sensor is calibrated with a wrong scale";
  double scale = 1.1;

  static void fields(auto& self, auto&& field) {
    field("scale", self.scale, {between(0.7, 1.4), "", "of the sensor", kRequired});
  }

  double measured(double position) const { return scale * position; }

  static std::vector<Shape<SensorScale>> shapes(const Survey& /*s*/) { return {{{{2.0}}, 0, -1, -0.3, 0.4}}; }
  static SensorScale combined(const Shape<SensorScale>& /*shape*/, std::span<const double> c) { return {1.0 + c[0]}; }

  bool operator==(const SensorScale&) const = default;
};

}  // namespace bayesctrl
