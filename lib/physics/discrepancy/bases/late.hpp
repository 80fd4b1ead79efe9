#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m - x, m' = (x - m) / time_constant: by how much a first-order lag is behind x.
template <Quantity kOf>
struct Late {
  static constexpr std::string_view kName = text_of(kOf, "late_position", "late_velocity", "late_input");
  static constexpr std::string_view kText =
      text_of(kOf, "the position that it had, less that of now", "the velocity that it had, less that of now",
              "the input that it had, less that of now");
  static constexpr Looks kLooks = looks_at(kOf);
  static constexpr bool kGoesOn = true;
  using Memory = double;
  double time_constant = 1.0;

  static void fields(auto& self, auto&& field) {
    field("time_constant", self.time_constant, {kPositive, "s", "of the lag", kRequired});
  }

  Memory begin(const Instant& at) const { return chosen<kOf>(at); }
  Memory after(Memory m, const Instant& at, double h) const { return lagged(m, chosen<kOf>(at), time_constant, h); }
  double value(const Instant& at, Memory m) const { return m - chosen<kOf>(at); }

  bool operator==(const Late&) const = default;
};

}  // namespace bayesctrl
