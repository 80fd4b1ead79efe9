#pragma once

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// gain u.
struct InputGain {
  static constexpr std::string_view kName = "input_gain";
  static constexpr std::string_view kEquation = "u := {gain} u";
  static constexpr std::string_view kText = "the motor is stronger or weaker than the model says";
  double gain = 1.1;

  static void fields(auto& self, auto&& field) {
    field("gain", self.gain, {between(0.2, 5.0), "", "of the input", kRequired, {.mean = 1.0}});
  }

  double transform(double u) const { return gain * u; }
  double slope() const { return gain; }  // the same for every u

  static std::vector<Shape<InputGain>> shapes(const OperatingRange& /*s*/) { return {{{{2.0}}, 0, -1, -0.8, 4.0}}; }
  static InputGain combined(const Shape<InputGain>& /*shape*/, std::span<const double> c) { return {1.0 + c[0]}; }
  static InputGain drawn(auto&& uniform, const DrawScales& s) {
    return {drawn_sign(uniform) < 0.0 ? 1.0 / (1.0 + s.strength) : 1.0 + s.strength};
  }

  bool operator==(const InputGain&) const = default;
};

}  // namespace bayesctrl
