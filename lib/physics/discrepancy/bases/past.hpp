#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m, m' = (exp(-(x - centre)^2 / (2 width^2)) - m) / time_constant; x the velocity or the input.
template <Quantity kOf>
struct Past {
  static constexpr std::string_view kName = text_of(kOf, "", "past_velocity", "past_input");
  static constexpr std::string_view kText = text_of(kOf, "", "a bell curve over the velocity, behind a first-order lag",
                                                    "a bell curve over the input, behind a first-order lag");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = false;
  static constexpr Quantity kOver = kOf;
  using Memory = double;
  double centre = 0.0;
  double width = 1.0;
  double time_constant = 1.0;

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, unit_of(kOf), "of the bell curve", kRequired});
    field("width", self.width, {kPositive, unit_of(kOf), "standard deviation of the bell curve", kRequired});
    field("time_constant", self.time_constant, {kPositive, "s", "of the lag", kRequired});
  }

  Memory begin(const Instant& at) const { return bell(chosen<kOf>(at), centre, width); }
  Memory after(Memory m, const Instant& at, double h) const { return lagged(m, begin(at), time_constant, h); }
  double value(const Instant& /*at*/, Memory m) const { return m; }

  bool operator==(const Past&) const = default;
};

}  // namespace bayesctrl
