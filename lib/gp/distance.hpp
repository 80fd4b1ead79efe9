#pragma once

#include <cmath>
#include <vector>

#include "base/fields.hpp"
#include "gp/inputs.hpp"

namespace bayesctrl {

/// ((X_d - x_d) / l_d)^2 for one dimension d; zero where the length scale is infinite.
inline BlockArray scaled_square(const InputBlock& inputs, const double* x, int d, double length_scale) {
  return ((inputs.column(d) - x[d]) * (1.0 / length_scale)).square();
}

/// r^2 = sum_d ((X_d - x_d) / l_d)^2.
inline BlockArray squared_distance(const InputBlock& inputs, const double* x, const std::vector<double>& scales) {
  BlockArray r2 = scaled_square(inputs, x, 0, scales[0]);
  for (int d = 1; d < inputs.dimension; ++d) r2 += scaled_square(inputs, x, d, scales[d]);
  return r2;
}

/// What every kernel with automatic relevance determination (ARD) has: the scale of the output and of each input.
struct ArdScales {
  double output_scale = 1.0;
  std::vector<double> length_scales{1.0, 1.0};

  static void fields(auto& self, auto&& field) {
    field("output_scale", self.output_scale, {kPositive, "output unit", "standard deviation of the function"});
    field("length_scales", self.length_scales,
          {kPositiveOrInfinite, "input unit", "one per input dimension (ARD); .inf: this input does not matter"});
  }

  /// k(x, x).
  double variance() const { return output_scale * output_scale; }

  bool operator==(const ArdScales&) const = default;
};

}  // namespace bayesctrl
