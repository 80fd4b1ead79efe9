#pragma once

#include <numbers>

#include "gp/distance.hpp"

namespace bayesctrl {

/// k = s^2 exp(-2 sum_d sin^2(pi (x_d - y_d) / period_d) / l_d^2): l_d scales the sine (Rasmussen & Williams 2006,
/// Eq. 4.31).
struct Periodic : ArdScales {
  static constexpr std::string_view kName = "periodic";
  static constexpr std::string_view kText =
      "s^2 exp(-2 sum sin^2(pi (x - y)/period)/l^2): functions that repeat, such as those of an angle";
  std::vector<double> periods{2.0 * std::numbers::pi, 2.0 * std::numbers::pi};

  static void fields(auto& self, auto&& field) {
    ArdScales::fields(self, field);
    field("periods", self.periods, {kPositive, "input unit", "one per input dimension"});
  }

  std::string problem() const {
    return periods.size() == length_scales.size() ? "" : "periodic needs as many periods as length_scales";
  }

  void evaluate(const InputBlock& inputs, const double* x, BlockArray& k) const {
    BlockArray sum = BlockArray::Zero(inputs.count);
    for (int d = 0; d < inputs.dimension; ++d) {
      if (length_scales[d] != kInfinity) sum += term(inputs, x, d);
    }
    k = variance() * (-2.0 * sum).exp();
  }

  void differentiate(const InputBlock& inputs, const double* x, BlockArray& k, BlockGradient& gradient) const {
    evaluate(inputs, x, k);
    gradient.col(0) = 2.0 * k;
    for (int d = 0; d < inputs.dimension; ++d) {
      auto by_scale = gradient.col(1 + d);
      auto by_period = gradient.col(1 + inputs.dimension + d);
      by_scale.setZero();
      by_period.setZero();
      if (length_scales[d] == kInfinity) continue;
      by_scale = 4.0 * k * term(inputs, x, d);
      const BlockArray phase = (inputs.column(d) - x[d]) * (std::numbers::pi / periods[d]);
      by_period = 2.0 * k * (2.0 * phase).sin() * phase / (length_scales[d] * length_scales[d]);
    }
  }

  bool operator==(const Periodic&) const = default;

 private:
  BlockArray term(const InputBlock& inputs, const double* x, int d) const {
    return (((inputs.column(d) - x[d]) * (std::numbers::pi / periods[d])).sin() * (1.0 / length_scales[d])).square();
  }
};

}  // namespace bayesctrl
