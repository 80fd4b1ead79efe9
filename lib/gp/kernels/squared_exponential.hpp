#pragma once

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 exp(-r^2 / 2) (Rasmussen & Williams 2006, Eq. 4.9), the paper's SE-ARD.
struct SquaredExponential {
  static constexpr std::string_view kName = "squared_exponential";
  static constexpr std::string_view kText = "s^2 exp(-r^2/2): infinitely smooth functions";
  double output_scale = 1.0;
  std::vector<double> length_scales{1.0, 1.0};

  static void fields(auto& self, auto&& field) {
    field("output_scale", self.output_scale, kOutputScaleInfo);
    field("length_scales", self.length_scales, kLengthScalesInfo);
  }

  double variance() const { return output_scale * output_scale; }

  void evaluate(const InputBlock& inputs, const double* x, BlockArray& k) const {
    k = variance() * (-0.5 * squared_distance(inputs, x, length_scales)).exp();
  }

  void differentiate(const InputBlock& inputs, const double* x, BlockArray& k, BlockGradient& gradient) const {
    evaluate(inputs, x, k);
    gradient.col(0) = 2.0 * k;
    for (int d = 0; d < inputs.dimension; ++d) {
      gradient.col(1 + d) = k * scaled_square(inputs, x, d, length_scales[d]);
    }
  }

  bool operator==(const SquaredExponential&) const = default;
};

}  // namespace bayesctrl
