#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// m tanh(v / smooth_over), m' = (v^2 - m) / time_constant, cold at first.
struct WarmDry {
  static constexpr std::string_view kName = "warm_dry";
  static constexpr std::string_view kText = "dry friction that changes as it warms up";
  static constexpr Looks kLooks{.velocity = true};
  static constexpr bool kGoesOn = false;
  using Memory = double;
  double time_constant = 1.0;
  double smooth_over = 1.0;

  static void fields(auto& self, auto&& field) {
    field("time_constant", self.time_constant, {kPositive, "s", "of the temperature", kRequired});
    field("smooth_over", self.smooth_over,
          {kPositive, "rad/s or m/s", "where the sign of the velocity bends", kRequired});
  }

  Memory begin(const Instant& /*at*/) const { return 0.0; }
  Memory after(Memory m, const Instant& at, double h) const {
    return lagged(m, at.velocity * at.velocity, time_constant, h);
  }
  double value(const Instant& at, Memory m) const { return m * std::tanh(at.velocity / smooth_over); }

  bool operator==(const WarmDry&) const = default;
};

}  // namespace bayesctrl
