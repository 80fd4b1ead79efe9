#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// exp(-(q - centre)^2 / (2 width^2)) tanh(v / smooth_over).
struct PositionDry {
  static constexpr std::string_view kName = "position_dry";
  static constexpr std::string_view kText = "dry friction where the joint is";
  static constexpr Looks kLooks{.position = true, .velocity = true};
  static constexpr bool kGoesOn = false;
  static constexpr Quantity kOver = Quantity::position;
  double centre = 0.0;
  double width = 1.0;
  double smooth_over = 1.0;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, "rad or m", "where it is strongest", kRequired});
    field("width", self.width, {kPositive, "rad or m", "standard deviation of the bell curve", kRequired});
    field("smooth_over", self.smooth_over,
          {kPositive, "rad/s or m/s", "where the sign of the velocity bends", kRequired});
  }

  double beside(const Instant& at) const { return std::tanh(at.velocity / smooth_over); }
  double value(const Instant& at) const { return bell(at.position, centre, width) * beside(at); }

  bool operator==(const PositionDry&) const = default;
};

}  // namespace bayesctrl
