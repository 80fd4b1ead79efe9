#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// tanh(x / width), x the velocity or the input: what jumps, or saturates.
template <Quantity kOf>
struct Sign {
  static constexpr std::string_view kName = text_of(kOf, "", "sign_velocity", "sign_input");
  static constexpr std::string_view kText = text_of(kOf, "", "the sign of the velocity, or what saturates in it",
                                                    "the sign of the input, or what saturates in it");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = false;
  double width = 1.0;

  static void fields(auto& self, auto&& field) {
    field("width", self.width, {kPositive, unit_of(kOf), "where tanh(x / width) bends", kRequired});
  }

  double value(const Instant& at) const { return std::tanh(chosen<kOf>(at) / width); }

  bool operator==(const Sign&) const = default;
};

}  // namespace bayesctrl
