#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Play: the output follows u only at the ends of a gap of half-width width.
struct Backlash {
  static constexpr std::string_view kName = "backlash";
  static constexpr std::string_view kEquation = "u := play of half-width {width}";
  static constexpr std::string_view kText = "play between motor and joint: after each reversal nothing moves at first";
  double width = 0.1;

  static void fields(auto& self, auto&& field) {
    field("width", self.width, {kPositive, "unit of u", "half of the gap", kRequired});
  }

  /// Output after the input moves to u, `before` being the output so far.
  double follow(double u, double before) const { return std::clamp(before, u - width, u + width); }

  static std::vector<Shape<Backlash>> shapes(const OperatingRange& s) {
    std::vector<Shape<Backlash>> list;
    for (const double tried : spread(0.003 * s.input, 0.9 * s.input, 14)) list.push_back({{{tried}}, 1});
    return list;
  }
  static Backlash combined(const Shape<Backlash>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].width};
  }
  static Backlash drawn(auto&& /*uniform*/, const DrawScales& s) { return {s.strength * s.input}; }

  bool operator==(const Backlash&) const = default;
};

}  // namespace bayesctrl
