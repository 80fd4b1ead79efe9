#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "gp/inputs.hpp"
#include "gp/kernel.hpp"

namespace bayesctrl {

/// A function of the input that a prior may use as its mean, e.g. the drift of a nominal model.
using MeanFunction = std::function<double(std::span<const double>)>;

/// Gaussian process prior f ~ GP(mean + mean_function(x), k) with observations y = f(x) + noise.
struct GaussianProcess {
  static constexpr int kMostBudget = 512;
  static constexpr std::string_view kName = "gaussian_process";
  static constexpr std::string_view kText = "f ~ GP(mean, kernel), observed as f + noise";
  double mean = 0.0;
  double noise_variance = 1e-4;
  std::optional<int> budget;
  Kernel kernel;
  MeanFunction mean_function;          // optional, added to `mean`; set by code, not read from specs
  std::vector<GaussianProcess> terms;  // likewise, of a weighted sum: see `weighted_sum`

  static void fields(auto& self, auto&& field) {
    field("mean", self.mean, {kAny, "output unit", "constant prior mean, added to the prior model's if there is one"});
    field("noise_variance", self.noise_variance, {kNonNegative, "output unit squared", "variance of the observations"});
    field("budget", self.budget,
          {between(4, kMostBudget), "",
           "samples that are kept as they are; more are absorbed by a sparse process of so many inputs; null: all. "
           "With a learner.monitor those of a and b that are given add up"});
    field("kernel", self.kernel, {.text = "covariance of the function", .required = true});
  }

  double prior_mean(std::span<const double> x) const {
    if (!terms.empty()) return mean_of_sum(x);
    return mean_function ? mean + mean_function(x) : mean;
  }

 private:
  double mean_of_sum(std::span<const double> x) const;
};

/// Most functions of a weighted sum.
inline constexpr int kMostTerms = 8;

/// One number for each term of a weighted sum.
using TermVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMostTerms, 1>;
using TermMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, kMostTerms, kMostTerms>;

/// Most entries of an input, weights included.
inline constexpr int kMostInputs = 24;

/// The process f(x, w) = sum_c w_c f_c(x) of independent functions f_c, whose weights are the last entries of its
/// input. Observed with several weights that are not zero the functions are independent no longer. `mean`, `kernel` and
/// `mean_function` of the sum have no meaning; its budget is what those that they have add up to.
GaussianProcess weighted_sum(std::vector<GaussianProcess> terms);

/// The process of one term, or of a function that is no sum itself.
inline const GaussianProcess& term_of(const GaussianProcess& prior, int term) {
  return prior.terms.empty() ? prior : prior.terms[static_cast<std::size_t>(term)];
}
inline GaussianProcess& term_of(GaussianProcess& prior, int term) {
  return prior.terms.empty() ? prior : prior.terms[static_cast<std::size_t>(term)];
}

/// Calls f(c, (x, e_c)) for each term: the inputs at which a weighted sum is f_c(x). `x` is without weights.
void for_each_term(const GaussianProcess& sum, std::span<const double> x, auto&& f) {
  std::array<double, kMostInputs> input{};
  std::copy(x.begin(), x.end(), input.begin());
  for (std::size_t c = 0; c < sum.terms.size(); ++c) {
    input[x.size() + c] = 1.0;
    f(static_cast<int>(c), std::span<const double>(input.data(), x.size() + sum.terms.size()));
    input[x.size() + c] = 0.0;
  }
}

/// Prior variance of f(x).
double variance(const GaussianProcess& prior, std::span<const double> x);

/// Prior covariance of f(x) with f at the inputs of one block.
void evaluate(const GaussianProcess& prior, const InputBlock& inputs, const double* x, BlockArray& k);

/// Throws std::invalid_argument unless the kernels are of inputs of this dimension (without the weights of a sum).
void require_dimension(const GaussianProcess& prior, int dimension);

/// Multiplies the function's scale by `factor`, its variance by the square.
void scale_output(GaussianProcess& prior, double factor);

}  // namespace bayesctrl
