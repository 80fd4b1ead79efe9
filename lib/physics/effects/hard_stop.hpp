#pragma once

#include <algorithm>
#include <cmath>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque -stiffness (q - position) - damping v beyond position: above it if position >= 0, below it otherwise. A stop
/// pushes and never pulls: where the damping would hold back what leaves it, there is no torque.
struct HardStop {
  static constexpr std::string_view kName = "hard_stop";
  static constexpr std::string_view kEquation =
      "torque -= {stiffness} (q - {position}) + {damping} v beyond {position}, where that pushes back";
  static constexpr std::string_view kText = "a bumper or end stop that the joint runs into";
  double position = 1.0;
  double stiffness = 100.0;
  double damping = 1.0;

  static void fields(auto& self, auto&& field) {
    field("position", self.position,
          {kAny, "rad", "where it begins", kRequired, {.deviation = {0.3, Measure::positions}}});
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "of the stop", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "of the stop", kRequired});
  }

  double side() const { return position >= 0.0 ? 1.0 : -1.0; }

  double depth_at(double q) const { return side() * (q - position); }
  double contact_rate(double mobility) const { return std::max(std::sqrt(stiffness * mobility), damping * mobility); }
  double torque_at(const JointState& s) const {
    const double depth = depth_at(s.position);
    return depth >= 0.0 ? -side() * std::max(0.0, stiffness * depth + damping * side() * s.velocity) : 0.0;
  }

  static std::vector<Shape<HardStop>> shapes(const OperatingRange& s) {
    constexpr int kPlaces = 14;
    std::vector<Shape<HardStop>> list;
    const auto add = [&](double from, double to) {
      for (int i = 0; i < kPlaces && from != to; ++i) {
        const double place = from + (to - from) * (i + 0.5) / kPlaces;
        list.push_back({{{place, 1.0, 0.0}, {place, 0.0, 1.0}}, 1});
      }
    };
    if (s.highest > 0.0) add(std::max(0.0, s.lowest), s.highest);
    if (s.lowest < 0.0) add(std::min(0.0, s.highest), s.lowest);
    return list;
  }
  static HardStop combined(const Shape<HardStop>& shape, std::span<const double> c) {
    HardStop stop = shape.members[0];
    stop.stiffness = c[0];
    stop.damping = c[1];
    return stop;
  }
  static HardStop drawn(auto&& uniform, const DrawScales& s) {
    const double side = drawn_sign(uniform), stiffness = s.strength * s.torque / s.range;
    return {side * uniform(0.2, 0.5) * s.range, stiffness, 0.05 * s.strength * s.torque / s.range};
  }

  bool operator==(const HardStop&) const = default;
};

}  // namespace bayesctrl
