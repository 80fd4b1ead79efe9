#pragma once

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 exp(-r^2 / 2) (Rasmussen & Williams 2006, Eq. 4.9), the paper's SE-ARD.
struct SquaredExponential : ArdScales {
  static constexpr std::string_view kName = "squared_exponential";
  static constexpr std::string_view kText = "s^2 exp(-r^2/2): infinitely smooth functions";

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
