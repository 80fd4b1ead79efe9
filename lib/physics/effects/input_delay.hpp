#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// u(t - delay), 0 before the first sample.
struct InputDelay {
  static constexpr std::string_view kName = "input_delay";
  static constexpr std::string_view kEquation = "u := u(t - {delay})";
  static constexpr std::string_view kText = "commands arrive late";
  double delay = 0.02;

  static void fields(auto& self, auto&& field) {
    field("delay", self.delay,
          {between(0.0, 0.2),
           "s",
           "of the input",
           kRequired,
           {.deviation = {0.3, Measure::admitted}, .step = {0.5, Measure::period}, .share = 0.05}});
  }

  double delay_time() const { return delay; }

  static std::vector<Shape<InputDelay>> shapes(const OperatingRange& s) {
    std::vector<Shape<InputDelay>> list;
    for (const double tried : spread(0.2 * s.period, 0.2, 16)) list.push_back({{{tried}}, 1});
    return list;
  }
  static InputDelay combined(const Shape<InputDelay>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].delay};
  }
  static InputDelay drawn(auto&& /*uniform*/, const DrawScales& s) { return {std::min(s.strength, 0.2)}; }

  bool operator==(const InputDelay&) const = default;
};

}  // namespace bayesctrl
