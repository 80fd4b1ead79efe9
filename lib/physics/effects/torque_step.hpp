#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// A constant torque from time on.
struct TorqueStep {
  static constexpr std::string_view kName = "torque_step";
  static constexpr std::string_view kEquation = "torque += {torque} from t = {time} s on";
  static constexpr std::string_view kText = "something changed suddenly: a part came loose or was added";
  static constexpr bool kOfTime = true;
  static constexpr std::string_view kJump = "torque";  // the parameter that says how large it is
  double torque = 0.1;
  double time = 1.0;

  static void fields(auto& self, auto&& field) {
    field("torque", self.torque, {kAny, "N m", "along q", kRequired});
    field("time", self.time,
          {kNonNegative,
           "s",
           "since the start of the recording",
           kRequired,
           {.deviation = {0.3, Measure::duration},
            .step = {2.0, Measure::period},
            .share = 0.0,
            .high = {1.0, Measure::duration}}});
  }

  double torque_at(const JointState& s) const { return s.time >= time ? torque : 0.0; }
  double switch_time() const { return time; }

  static std::vector<Shape<TorqueStep>> shapes(const OperatingRange& s) {
    std::vector<Shape<TorqueStep>> list;
    for (std::size_t r = 0; r < s.durations.size(); ++r) {
      const double length = s.durations[r], step = std::max(0.1, length / 200.0);
      for (double at = 0.05 * length; at <= 0.95 * length; at += step) list.push_back({{{1.0, at}}, 0, int(r)});
    }
    return list;
  }
  static TorqueStep combined(const Shape<TorqueStep>& shape, std::span<const double> c) {
    return {c[0], shape.members[0].time};
  }
  static TorqueStep drawn(auto&& uniform, const DrawScales& s) {
    const double torque = drawn_sign(uniform) * s.strength * s.torque;
    return {torque, uniform(0.2, 0.8) * s.duration};
  }

  bool operator==(const TorqueStep&) const = default;
};

}  // namespace bayesctrl
