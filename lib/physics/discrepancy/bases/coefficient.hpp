#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// exp(-(x - centre)^2 / (2 width^2)) y: a drag (y the velocity) or a gain (y the input) that is a function of x.
template <Quantity kOf, Quantity kTimes>
struct Coefficient {
  static constexpr std::string_view kName = kTimes == Quantity::velocity
                                                ? text_of(kOf, "position_drag", "", "", "time_drag")
                                                : text_of(kOf, "position_gain", "velocity_gain", "", "time_gain");
  static constexpr std::string_view kText =
      kTimes == Quantity::velocity
          ? text_of(kOf, "viscous friction where the joint is", "", "", "viscous friction at a time")
          : text_of(kOf, "an input gain where the joint is", "an input gain at a velocity", "",
                    "an input gain at a time");
  static constexpr Looks kLooks = looks_at(kOf) | looks_at(kTimes);
  static constexpr bool kGoesOn = false;
  static constexpr Quantity kOver = kOf;
  double centre = 0.0;
  double width = 1.0;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, unit_of(kOf), "where it is strongest", kRequired});
    field("width", self.width, {kPositive, unit_of(kOf), "standard deviation of the bell curve", kRequired});
  }

  double beside(const Instant& at) const { return chosen<kTimes>(at); }
  double value(const Instant& at) const { return bell(chosen<kOf>(at), centre, width) * beside(at); }

  bool operator==(const Coefficient&) const = default;
};

}  // namespace bayesctrl
