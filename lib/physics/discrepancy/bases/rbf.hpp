#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// exp(-(x - centre)^2 / (2 width^2)), x a quantity: any function of it, in pieces.
template <Quantity kOf>
struct Rbf {
  static constexpr std::string_view kName = text_of(kOf, "bump_position", "bump_velocity", "bump_input", "bump_time");
  static constexpr std::string_view kText =
      text_of(kOf, "a bell curve over the position", "a bell curve over the velocity", "a bell curve over the input",
              "a bell curve over the time");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = false;
  static constexpr Quantity kOver = kOf;
  double centre = 0.0;
  double width = 1.0;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, unit_of(kOf), "where it is 1", kRequired});
    field("width", self.width, {kPositive, unit_of(kOf), "standard deviation of the bell curve", kRequired});
  }

  double beside(const Instant& /*at*/) const { return 1.0; }
  double value(const Instant& at) const { return bell(chosen<kOf>(at), centre, width); }

  bool operator==(const Rbf&) const = default;
};

}  // namespace bayesctrl
