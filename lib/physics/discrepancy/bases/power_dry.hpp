#pragma once

#include "physics/discrepancy/bases/power.hpp"

namespace bayesctrl {

/// |q|^exponent tanh(v / smooth_over), with the sign of q if it is odd.
struct PowerDry {
  static constexpr std::string_view kName = "power_dry";
  static constexpr std::string_view kText = "dry friction that grows with a power of the position";
  static constexpr Looks kLooks{.position = true, .velocity = true};
  static constexpr bool kGoesOn = true;
  double exponent = 1.0;
  bool odd = false;
  double smooth_over = 1.0;

  static void fields(auto& self, auto&& field) {
    field("exponent", self.exponent, {kNonNegative, "", "of the position's magnitude", kRequired});
    field("odd", self.odd, {.text = "whether it has the sign of the position", .required = true});
    field("smooth_over", self.smooth_over,
          {kPositive, "rad/s or m/s", "where the sign of the velocity bends", kRequired});
  }

  double value(const Instant& at) const {
    return power(at.position, exponent, odd) * std::tanh(at.velocity / smooth_over);
  }

  bool operator==(const PowerDry&) const = default;
};

}  // namespace bayesctrl
