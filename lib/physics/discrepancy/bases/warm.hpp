#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m x, m' = (x^2 - m) / time_constant, cold at first: viscous friction (x the velocity) or a gain (x the input) that
/// changes with the heat that it makes.
template <Quantity kOf>
struct Warm {
  static constexpr std::string_view kName = text_of(kOf, "", "warm_viscous", "warm_motor");
  static constexpr std::string_view kText = text_of(kOf, "", "viscous friction that changes as it warms up",
                                                    "an input gain that changes as the motor warms up");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = false;
  using Memory = double;
  double time_constant = 1.0;

  static void fields(auto& self, auto&& field) {
    field("time_constant", self.time_constant, {kPositive, "s", "of the temperature", kRequired});
  }

  Memory begin(const Instant& /*at*/) const { return 0.0; }
  Memory after(Memory m, const Instant& at, double h) const {
    const double x = chosen<kOf>(at);
    return lagged(m, x * x, time_constant, h);
  }
  double value(const Instant& at, Memory m) const { return m * chosen<kOf>(at); }

  bool operator==(const Warm&) const = default;
};

}  // namespace bayesctrl
