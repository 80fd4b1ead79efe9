#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// u limited to +-limit.
struct InputSaturation {
  static constexpr std::string_view kName = "input_saturation";
  static constexpr std::string_view kText = "the motor or amplifier cannot give more than a limit";
  double limit = 1.0;

  static void fields(auto& self, auto&& field) {
    field("limit", self.limit, {kPositive, "unit of u", "of the input", kRequired});
  }

  double transform(double u) const { return std::clamp(u, -limit, limit); }

  bool operator==(const InputSaturation&) const = default;
};

}  // namespace bayesctrl
