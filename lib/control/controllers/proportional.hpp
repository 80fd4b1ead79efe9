#pragma once

#include "control/law_input.hpp"

namespace bayesctrl {

/// The paper's baseline P_k, u = k u'(x), acting in continuous time.
struct Proportional {
  static constexpr std::string_view kName = "proportional";
  static constexpr std::string_view kText =
      "the paper's baseline P_k: u = gain (w1 (xi1 - x1) + w2 (xi2 - x2)), continuous";
  static constexpr bool kContinuous = true;
  static constexpr Knowledge kKnowledge = Knowledge::nothing;
  double gain = 1.0;

  static void fields(auto& self, auto&& field) {
    field("gain", self.gain, {kNonNegative, "unit of u per rad/s^2", "k", kRequired});
  }

  JointVector operator()(const LawInput& in) const { return gain * in.acceleration; }
  bool operator==(const Proportional&) const = default;
};

}  // namespace bayesctrl
