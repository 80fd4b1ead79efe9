#pragma once

#include "physics/discrepancy/bases/power.hpp"

namespace bayesctrl {

/// |q|^exponent u, with the sign of q if it is odd.
struct PowerGain {
  static constexpr std::string_view kName = "power_gain";
  static constexpr std::string_view kText = "an input gain that grows with a power of the position";
  static constexpr Looks kLooks{.position = true, .input = true};
  static constexpr bool kGoesOn = true;
  double exponent = 1.0;
  bool odd = false;

  static void fields(auto& self, auto&& field) {
    field("exponent", self.exponent, {kNonNegative, "", "of the position's magnitude", kRequired});
    field("odd", self.odd, {.text = "whether it has the sign of the position", .required = true});
  }

  double value(const Instant& at) const { return power(at.position, exponent, odd) * at.input; }

  bool operator==(const PowerGain&) const = default;
};

}  // namespace bayesctrl
