#pragma once

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 (1 + sqrt(3) r) exp(-sqrt(3) r) (Rasmussen & Williams 2006, Eq. 4.17).
struct Matern32 : ArdScales {
  static constexpr std::string_view kName = "matern32";
  static constexpr std::string_view kText =
      "s^2 (1 + sqrt(3) r) exp(-sqrt(3) r): functions that are once differentiable";

  void evaluate(const InputBlock& inputs, const double* x, BlockArray& k) const {
    const BlockArray r = (3.0 * squared_distance(inputs, x, length_scales)).sqrt();
    k = variance() * (1.0 + r) * (-r).exp();
  }

  void differentiate(const InputBlock& inputs, const double* x, BlockArray& k, BlockGradient& gradient) const {
    const BlockArray r = (3.0 * squared_distance(inputs, x, length_scales)).sqrt();
    const BlockArray decay = variance() * (-r).exp();
    k = (1.0 + r) * decay;
    gradient.col(0) = 2.0 * k;
    for (int d = 0; d < inputs.dimension; ++d) {
      gradient.col(1 + d) = 3.0 * decay * scaled_square(inputs, x, d, length_scales[d]);
    }
  }

  bool operator==(const Matern32&) const = default;
};

}  // namespace bayesctrl
