#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// |x|^exponent, with the sign of x if it is odd.
inline double power(double x, double exponent, bool odd) {
  const double size = std::pow(std::abs(x), exponent);
  return odd ? std::copysign(size, x) : size;
}

/// A power of one quantity.
template <Quantity kOf>
struct Power {
  static constexpr std::string_view kName = text_of(kOf, "power_position", "power_velocity", "power_input");
  static constexpr std::string_view kText =
      text_of(kOf, "a power of the position", "a power of the velocity", "a power of the input");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = true;
  double exponent = 1.0;
  bool odd = true;

  static void fields(auto& self, auto&& field) {
    field("exponent", self.exponent, {kNonNegative, "", "of the magnitude", kRequired});
    field("odd", self.odd, {.text = "whether it has the sign of what it is a power of", .required = true});
  }

  double value(const Instant& at) const { return power(chosen<kOf>(at), exponent, odd); }

  bool operator==(const Power&) const = default;
};

}  // namespace bayesctrl
