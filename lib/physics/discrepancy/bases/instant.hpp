#pragma once

#include <cmath>
#include <complex>
#include <string_view>

#include "base/fields.hpp"

namespace bayesctrl {

/// What moves in one joint at one time.
struct Instant {
  double position = 0.0, velocity = 0.0, input = 0.0, time = 0.0;
};
enum class Quantity { position, velocity, input, time };

template <Quantity kOf>
double chosen(const Instant& at) {
  if constexpr (kOf == Quantity::position) return at.position;
  if constexpr (kOf == Quantity::velocity) return at.velocity;
  if constexpr (kOf == Quantity::input) return at.input;
  if constexpr (kOf == Quantity::time) return at.time;
}

/// The text for one of the quantities.
constexpr std::string_view text_of(Quantity quantity, std::string_view position, std::string_view velocity,
                                   std::string_view input, std::string_view time = "") {
  return quantity == Quantity::position   ? position
         : quantity == Quantity::velocity ? velocity
         : quantity == Quantity::input    ? input
                                          : time;
}
constexpr std::string_view unit_of(Quantity quantity) {
  return text_of(quantity, "rad or m", "rad/s or m/s", "unit of u", "s");
}

/// What the value of a basis is a function of, now or in the past, besides the time.
struct Looks {
  bool position = false, velocity = false, input = false;

  constexpr Looks operator|(const Looks& other) const {
    return {position || other.position, velocity || other.velocity, input || other.input};
  }
  constexpr int count() const { return position + velocity + input; }
};
constexpr Looks looks_at(Quantity quantity) {
  return {quantity == Quantity::position, quantity == Quantity::velocity, quantity == Quantity::input};
}

/// A bell curve of height 1.
inline double bell(double x, double centre, double width) {
  const double z = (x - centre) / width;
  return std::exp(-0.5 * z * z);
}

/// What follows something as a first-order lag, `h` seconds on.
inline double lagged(double m, double towards, double time_constant, double h) {
  return m - (towards - m) * std::expm1(-h / time_constant);
}

}  // namespace bayesctrl
