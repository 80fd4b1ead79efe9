#pragma once

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 (1 + r^2 / (2 shape))^-shape (Rasmussen & Williams 2006, Eq. 4.19), the paper's RQ-ARD.
struct RationalQuadratic : ArdScales {
  static constexpr std::string_view kName = "rational_quadratic";
  static constexpr std::string_view kText =
      "s^2 (1 + r^2/(2 shape))^-shape: a mixture of length scales; a large shape tends to the squared exponential";
  double shape = 1.0;

  static void fields(auto& self, auto&& field) {
    ArdScales::fields(self, field);
    field("shape", self.shape, {kPositive, "", "alpha: the spread of the length scales"});
  }

  void evaluate(const InputBlock& inputs, const double* x, BlockArray& k) const {
    const BlockArray base = 1.0 + squared_distance(inputs, x, length_scales) * (0.5 / shape);
    k = variance() * (-shape * base.log()).exp();
  }

  void differentiate(const InputBlock& inputs, const double* x, BlockArray& k, BlockGradient& gradient) const {
    const BlockArray base = 1.0 + squared_distance(inputs, x, length_scales) * (0.5 / shape);
    const BlockArray log_base = base.log();
    k = variance() * (-shape * log_base).exp();
    gradient.col(0) = 2.0 * k;
    for (int d = 0; d < inputs.dimension; ++d) {
      gradient.col(1 + d) = k / base * scaled_square(inputs, x, d, length_scales[d]);
    }
    gradient.col(1 + inputs.dimension) = shape * k * (1.0 - base.inverse() - log_base);
  }

  bool operator==(const RationalQuadratic&) const = default;
};

}  // namespace bayesctrl
