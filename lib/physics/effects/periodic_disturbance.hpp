#pragma once

#include <algorithm>
#include <numbers>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Torque amplitude sin(frequency t + phase).
struct PeriodicDisturbance {
  static constexpr std::string_view kName = "periodic_disturbance";
  static constexpr std::string_view kEquation = "torque += {amplitude} sin({frequency} t + {phase})";
  static constexpr std::string_view kText = "a shaking from outside at a fixed frequency";
  static constexpr bool kOfTime = true;
  double amplitude = 0.1;
  double frequency = 6.0;
  double phase = 0.0;

  static void fields(auto& self, auto&& field) {
    field("amplitude", self.amplitude, {kPositive, "N m", "of the disturbance", kRequired});
    field("frequency", self.frequency,
          {kPositive,
           "rad/s",
           "below half the sampling rate",
           kRequired,
           {.deviation = {20.0},
            .step = {1e-3},
            .share = 0.0,
            .low = {1.0, Measure::per_duration},
            .high = {std::numbers::pi, Measure::rate}}});
    field("phase", self.phase, {kAny, "rad", "at the start of each recording", kRequired, kAngle});
  }

  double torque_at(const JointState& s) const { return amplitude * std::sin(frequency * s.time + phase); }

  /// Neighbouring frequencies differ by less than a radian and a half of phase over the longest recording.
  static std::vector<Shape<PeriodicDisturbance>> shapes(const OperatingRange& s) {
    std::vector<Shape<PeriodicDisturbance>> list;
    const double step = 1.6 / std::min(*std::max_element(s.durations.begin(), s.durations.end()), kCoherent);
    for (const double tried : s.frequencies(step, std::min(0.9 * std::numbers::pi / s.period, kHighest))) {
      list.push_back({{{1.0, tried, 0.0}, {1.0, tried, std::numbers::pi / 2.0}}});
    }
    return list;
  }
  static PeriodicDisturbance combined(const Shape<PeriodicDisturbance>& shape, std::span<const double> c) {
    return {std::hypot(c[0], c[1]), shape.members[0].frequency, std::atan2(c[1], c[0])};
  }
  static constexpr double kHighest = 60.0;     // rad/s, of the shapes
  static constexpr double kCoherent = 7200.0;  // s, over which a disturbance may keep its phase
  static PeriodicDisturbance drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque, uniform(3.0, 30.0), uniform(0.0, 2.0 * std::numbers::pi)};
  }

  bool operator==(const PeriodicDisturbance&) const = default;
};

}  // namespace bayesctrl
