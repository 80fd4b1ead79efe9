#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m, m' = (tanh(x / width) - m) / time_constant; x the velocity or the input.
template <Quantity kOf>
struct LateSign {
  static constexpr std::string_view kName = text_of(kOf, "", "late_drag", "late_push");
  static constexpr std::string_view kText = text_of(kOf, "", "what saturates in the velocity, behind a first-order lag",
                                                    "what saturates in the input, behind a first-order lag");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = false;
  using Memory = double;
  double width = 1.0;
  double time_constant = 1.0;

  static void fields(auto& self, auto&& field) {
    field("width", self.width, {kPositive, unit_of(kOf), "where tanh(x / width) bends", kRequired});
    field("time_constant", self.time_constant, {kPositive, "s", "of the lag", kRequired});
  }

  Memory begin(const Instant& at) const { return std::tanh(chosen<kOf>(at) / width); }
  Memory after(Memory m, const Instant& at, double h) const { return lagged(m, begin(at), time_constant, h); }
  double value(const Instant& /*at*/, Memory m) const { return m; }

  bool operator==(const LateSign&) const = default;
};

}  // namespace bayesctrl
