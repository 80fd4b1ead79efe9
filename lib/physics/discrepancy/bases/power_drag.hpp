#pragma once

#include "physics/discrepancy/bases/power.hpp"

namespace bayesctrl {

/// |q|^exponent |v|, with the sign of q if it is odd and that of v if it is directed.
struct PowerDrag {
  static constexpr std::string_view kName = "power_drag";
  static constexpr std::string_view kText = "viscous friction that grows with a power of the position";
  static constexpr Looks kLooks{.position = true, .velocity = true};
  static constexpr bool kGoesOn = true;
  double exponent = 1.0;
  bool odd = false;
  bool directed = true;

  static void fields(auto& self, auto&& field) {
    field("exponent", self.exponent, {kNonNegative, "", "of the position's magnitude", kRequired});
    field("odd", self.odd, {.text = "whether it has the sign of the position", .required = true});
    field("directed", self.directed, {.text = "whether it has the sign of the velocity", .required = true});
  }

  double value(const Instant& at) const {
    return power(at.position, exponent, odd) * power(at.velocity, 1.0, directed);
  }

  bool operator==(const PowerDrag&) const = default;
};

}  // namespace bayesctrl
