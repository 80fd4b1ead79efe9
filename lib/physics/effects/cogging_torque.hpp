#pragma once

#include <algorithm>
#include <numbers>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque amplitude sin(order q + phase).
struct CoggingTorque {
  static constexpr std::string_view kName = "cogging_torque";
  static constexpr std::string_view kEquation = "torque += {amplitude} sin({order} q + {phase})";
  static constexpr std::string_view kText =
      "a torque that pulses with the rotor's position, from magnets or gear teeth";
  static constexpr bool kNeedsTurning = true;
  double amplitude = 0.1;
  double order = 6.0;
  double phase = 0.0;

  static void fields(auto& self, auto&& field) {
    field("amplitude", self.amplitude, {kPositive, "N m", "of the pulsation", kRequired});
    field("order", self.order,
          {between(2.0, 30.0),
           "",
           "pulses per turn",
           kRequired,
           {.deviation = {0.3, Measure::admitted}, .step = {1e-3}, .share = 0.0}});
    field("phase", self.phase, {kAny, "rad", "at q = 0", kRequired, kAngle});
  }

  double torque_at(const JointState& s) const { return amplitude * std::sin(order * s.position + phase); }

  /// Neighbouring orders differ by less than a radian of phase over the range of positions.
  static std::vector<Shape<CoggingTorque>> shapes(const OperatingRange& s) {
    std::vector<Shape<CoggingTorque>> list;
    const double step = std::clamp(1.2 / std::max(s.highest - s.lowest, 1e-6), 0.1, 1.0);
    for (int i = 0; 2.0 + i * step <= 30.0 + 1e-9; ++i) {
      const double tried = 2.0 + i * step;
      list.push_back({{{1.0, tried, 0.0}, {1.0, tried, std::numbers::pi / 2.0}}});
    }
    return list;
  }
  static CoggingTorque combined(const Shape<CoggingTorque>& shape, std::span<const double> c) {
    return {std::hypot(c[0], c[1]), shape.members[0].order, std::atan2(c[1], c[0])};
  }
  static CoggingTorque drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque, std::round(uniform(3.0, 20.0)), uniform(0.0, 2.0 * std::numbers::pi)};
  }

  bool operator==(const CoggingTorque&) const = default;
};

}  // namespace bayesctrl
