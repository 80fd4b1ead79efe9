#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// exp(-(q - position)^2 / (2 position_width^2) - (v - velocity)^2 / (2 velocity_width^2)).
struct RbfState {
  static constexpr std::string_view kName = "bump_state";
  static constexpr std::string_view kText = "a bell curve over position and velocity";
  static constexpr Looks kLooks{.position = true, .velocity = true};
  static constexpr bool kGoesOn = false;
  double position = 0.0;
  double position_width = 1.0;
  double velocity = 0.0;
  double velocity_width = 1.0;

  static void fields(auto& self, auto&& field) {
    field("position", self.position, {kAny, "rad or m", "centre", kRequired});
    field("position_width", self.position_width, {kPositive, "rad or m", "standard deviation", kRequired});
    field("velocity", self.velocity, {kAny, "rad/s or m/s", "centre", kRequired});
    field("velocity_width", self.velocity_width, {kPositive, "rad/s or m/s", "standard deviation", kRequired});
  }

  double value(const Instant& at) const {
    return bell(at.position, position, position_width) * bell(at.velocity, velocity, velocity_width);
  }

  bool operator==(const RbfState&) const = default;
};

}  // namespace bayesctrl
