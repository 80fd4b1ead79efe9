#pragma once

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 (1 + z + z^2 / 3) exp(-z), z = sqrt(5) r (Rasmussen & Williams 2006, Eq. 4.17).
struct Matern52 : ArdScales {
  static constexpr std::string_view kName = "matern52";
  static constexpr std::string_view kText =
      "s^2 (1 + sqrt(5) r + 5 r^2/3) exp(-sqrt(5) r): functions that are twice differentiable";

  void evaluate(const InputBlock& inputs, const double* x, BlockArray& k) const {
    const BlockArray z = (5.0 * squared_distance(inputs, x, length_scales)).sqrt();
    k = variance() * (1.0 + z + z.square() / 3.0) * (-z).exp();
  }

  void differentiate(const InputBlock& inputs, const double* x, BlockArray& k, BlockGradient& gradient) const {
    const BlockArray z = (5.0 * squared_distance(inputs, x, length_scales)).sqrt();
    const BlockArray decay = variance() * (-z).exp();
    k = (1.0 + z + z.square() / 3.0) * decay;
    gradient.col(0) = 2.0 * k;
    for (int d = 0; d < inputs.dimension; ++d) {
      gradient.col(1 + d) = (5.0 / 3.0) * (1.0 + z) * decay * scaled_square(inputs, x, d, length_scales[d]);
    }
  }

  bool operator==(const Matern52&) const = default;
};

}  // namespace bayesctrl
