#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// u limited to +-limit.
struct InputSaturation {
  static constexpr std::string_view kName = "input_saturation";
  static constexpr std::string_view kEquation = "u := clamp(u, -{limit}, {limit})";
  static constexpr std::string_view kText = "the motor or amplifier cannot give more than a limit";
  double limit = 1.0;

  static void fields(auto& self, auto&& field) {
    field("limit", self.limit, {kPositive, "unit of u", "of the input", kRequired});
  }

  double transform(double u) const { return std::clamp(u, -limit, limit); }

  static std::vector<Shape<InputSaturation>> shapes(const OperatingRange& s) {
    std::vector<Shape<InputSaturation>> list;
    for (int i = 0; i < 20; ++i) list.push_back({{{s.input * (0.99 - 0.04 * i)}}, 1});
    return s.input > 0.0 ? list : std::vector<Shape<InputSaturation>>{};
  }
  static InputSaturation combined(const Shape<InputSaturation>& shape, std::span<const double> /*c*/) {
    return shape.members[0];
  }
  static InputSaturation drawn(auto&& /*uniform*/, const DrawScales& s) {
    return {s.input * std::max(0.02, 1.5 - s.strength)};
  }

  bool operator==(const InputSaturation&) const = default;
};

}  // namespace bayesctrl
