#pragma once

#include <algorithm>

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// tanh((m - centre) / width), m follows q at the ends of a gap.
struct Relay {
  static constexpr std::string_view kName = "relay";
  static constexpr std::string_view kText = "1 or -1, which changes at one position going up and at another going down";
  static constexpr Looks kLooks{.position = true};
  static constexpr bool kGoesOn = false;
  using Memory = double;
  double centre = 0.0;
  double width = 1.0;
  double half_gap = 0.1;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, "rad or m", "between the two positions", kRequired});
    field("width", self.width, {kPositive, "rad or m", "over which it changes", kRequired});
    field("half_gap", self.half_gap, {kNonNegative, "rad or m", "half the distance of the two positions", kRequired});
  }

  Memory begin(const Instant& at) const { return at.position; }
  Memory after(Memory m, const Instant& at, double /*h*/) const {
    return std::clamp(m, at.position - half_gap, at.position + half_gap);
  }
  double value(const Instant& /*at*/, Memory m) const { return std::tanh((m - centre) / width); }

  bool operator==(const Relay&) const = default;
};

}  // namespace bayesctrl
