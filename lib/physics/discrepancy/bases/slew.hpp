#pragma once

#include <algorithm>

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m - u, m follows u at `rate` at most.
struct Slew {
  static constexpr std::string_view kName = "slew_input";
  static constexpr std::string_view kText = "the input as an amplifier of limited rate has it, less the input";
  static constexpr Looks kLooks{.input = true};
  static constexpr bool kGoesOn = true;
  using Memory = double;
  double rate = 1.0;

  static void fields(auto& self, auto&& field) {
    field("rate", self.rate, {kNonNegative, "unit of u per s", "at most", kRequired});
  }

  Memory begin(const Instant& at) const { return at.input; }
  Memory after(Memory m, const Instant& at, double h) const { return std::clamp(at.input, m - rate * h, m + rate * h); }
  double value(const Instant& at, Memory m) const { return m - at.input; }

  bool operator==(const Slew&) const = default;
};

}  // namespace bayesctrl
