#pragma once

#include <algorithm>

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m - q, m follows q at the ends of a gap.
struct Play {
  static constexpr std::string_view kName = "play";
  static constexpr std::string_view kText = "where a part that the joint drags along with play is, less the position";
  static constexpr Looks kLooks{.position = true};
  static constexpr bool kGoesOn = true;
  using Memory = double;
  double half_width = 0.1;

  static void fields(auto& self, auto&& field) {
    field("half_width", self.half_width, {kNonNegative, "rad or m", "of the gap", kRequired});
  }

  Memory begin(const Instant& at) const { return at.position; }
  Memory after(Memory m, const Instant& at, double /*h*/) const {
    return std::clamp(m, at.position - half_width, at.position + half_width);
  }
  double value(const Instant& at, Memory m) const { return m - at.position; }

  bool operator==(const Play&) const = default;
};

}  // namespace bayesctrl
