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

/// Declarations shared by all kernels.
inline constexpr Info kOutputScaleInfo{kPositive, "output unit", "standard deviation of the function"};
inline constexpr Info kLengthScalesInfo{kPositiveOrInfinite, "input unit",
                                        "one per input dimension (ARD); .inf: this input does not matter"};

}  // namespace bayesctrl
