#pragma once

#include <algorithm>
#include <array>

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

enum class Side { below, above };
constexpr std::array<std::string_view, 2> names(Side) { return {"below", "above"}; }

/// max(x - threshold, 0) above a threshold, min(x - threshold, 0) below it; x the velocity or the input.
template <Quantity kOf>
struct Hinge {
  static constexpr std::string_view kName = text_of(kOf, "", "hinge_velocity", "hinge_input");
  static constexpr std::string_view kText =
      text_of(kOf, "", "linear in the velocity from a threshold on", "linear in the input from a threshold on");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = true;
  double threshold = 0.0;
  Side side = Side::above;

  static void fields(auto& self, auto&& field) {
    field("threshold", self.threshold, {kAny, unit_of(kOf), "where it is 0", kRequired});
    field("side", self.side, {.text = "of the threshold, where it is not 0", .required = true});
  }

  double value(const Instant& at) const {
    const double beyond = chosen<kOf>(at) - threshold;
    return side == Side::above ? std::max(beyond, 0.0) : std::min(beyond, 0.0);
  }

  bool operator==(const Hinge&) const = default;
};

}  // namespace bayesctrl
