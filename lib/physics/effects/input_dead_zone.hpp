#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// sign(u) max(|u| - width, 0).
struct InputDeadZone {
  static constexpr std::string_view kName = "input_dead_zone";
  static constexpr std::string_view kEquation = "u := sign(u) max(|u| - {width}, 0)";
  static constexpr std::string_view kText = "small commands do nothing";
  double width = 0.1;

  static void fields(auto& self, auto&& field) {
    field("width", self.width, {kPositive, "unit of u", "of the zone, to each side", kRequired});
  }

  double transform(double u) const { return std::copysign(std::max(std::abs(u) - width, 0.0), u); }

  static std::vector<Shape<InputDeadZone>> shapes(const OperatingRange& s) {
    std::vector<Shape<InputDeadZone>> list;
    for (const double tried : spread(0.003 * s.input, 0.9 * s.input, 14)) list.push_back({{{tried}}, 1});
    return list;
  }
  static InputDeadZone combined(const Shape<InputDeadZone>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].width};
  }
  static InputDeadZone drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.input}; }

  bool operator==(const InputDeadZone&) const = default;
};

}  // namespace bayesctrl
