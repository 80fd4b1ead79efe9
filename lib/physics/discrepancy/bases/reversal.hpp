#pragma once

#include "physics/discrepancy/bases/instant.hpp"

namespace bayesctrl {

/// exp(-|m| / time_constant) tanh(v / smooth_over), |m| the time since the velocity changed its sign, m of that sign.
struct Reversal {
  static constexpr std::string_view kName = "reversal";
  static constexpr std::string_view kText = "dry friction that dies away after the joint has turned";
  static constexpr Looks kLooks{.velocity = true};
  static constexpr bool kGoesOn = true;
  using Memory = double;
  double time_constant = 1.0;
  double smooth_over = 1.0;

  static void fields(auto& self, auto&& field) {
    field("time_constant", self.time_constant, {kPositive, "s", "over which it dies away", kRequired});
    field("smooth_over", self.smooth_over,
          {kPositive, "rad/s or m/s", "where the sign of the velocity bends", kRequired});
  }

  Memory begin(const Instant& at) const { return std::copysign(kJustNow, at.velocity); }
  Memory after(Memory m, const Instant& at, double h) const {
    return at.velocity * m < 0.0 ? begin(at) : m + std::copysign(h, m);
  }
  double value(const Instant& at, Memory m) const {
    return std::exp(-std::abs(m) / time_constant) * std::tanh(at.velocity / smooth_over);
  }

  bool operator==(const Reversal&) const = default;

 private:
  static constexpr double kJustNow = 1e-9;  // s: not 0, which has no sign
};

}  // namespace bayesctrl
