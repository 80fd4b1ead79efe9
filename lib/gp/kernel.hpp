#pragma once

#include <functional>
#include <span>
#include <variant>
#include <vector>

#include "gp/kernels/matern32.hpp"
#include "gp/kernels/matern52.hpp"
#include "gp/kernels/periodic.hpp"
#include "gp/kernels/rational_quadratic.hpp"
#include "gp/kernels/squared_exponential.hpp"

namespace bayesctrl {

struct Kernel;

/// k = sum of the terms: effects that add up.
struct Sum {
  static constexpr std::string_view kName = "sum";
  static constexpr std::string_view kText = "sum of kernels: effects that add up";
  std::vector<Kernel> terms;

  static void fields(auto& self, auto&& field) { field("terms", self.terms, {.text = "kernels", .required = true}); }
  std::string problem() const;
  bool operator==(const Sum&) const;
};

/// k = product of the factors: for example periodic in the angle, smooth in the velocity.
struct Product {
  static constexpr std::string_view kName = "product";
  static constexpr std::string_view kText =
      "product of kernels, for example periodic in the angle and smooth in velocity";
  std::vector<Kernel> factors;

  static void fields(auto& self, auto&& field) {
    field("factors", self.factors, {.text = "kernels", .required = true});
  }
  std::string problem() const;
  bool operator==(const Product&) const;
};

/// A covariance function over inputs of any dimension. A new kernel is one file in kernels/ and one line here; it needs
/// `fields`, `variance` (k at distance zero), `evaluate` and `differentiate` (by the logarithms of its parameters).
struct Kernel {
  std::variant<SquaredExponential, RationalQuadratic, Matern32, Matern52, Periodic, Sum, Product> form;

  bool operator==(const Kernel&) const = default;
};

inline std::string Sum::problem() const { return terms.empty() ? "sum needs at least one kernel in terms" : ""; }
inline std::string Product::problem() const {
  return factors.empty() ? "product needs at least one kernel in factors" : "";
}
inline bool Sum::operator==(const Sum& other) const { return terms == other.terms; }
inline bool Product::operator==(const Product& other) const { return factors == other.factors; }

/// k(x, x).
double variance(const Kernel& kernel);

/// k(x, y) / k(x, x) of two inputs.
double correlation(const Kernel& kernel, std::span<const double> x, std::span<const double> y);

/// Multiplies the function's scale by `factor`, its variance by the square.
void scale_output(Kernel& kernel, double factor);

/// k(x, X_i) for the inputs of one block.
void evaluate(const Kernel& kernel, const InputBlock& inputs, const double* x, BlockArray& k);

/// The same, and its derivatives by the logarithm of each hyper-parameter in the order of `hyper_parameters`; the
/// gradient is resized to fit. Derivatives by an infinite length scale are zero.
void differentiate(const Kernel& kernel, const InputBlock& inputs, const double* x, BlockArray& k,
                   BlockGradient& gradient);

/// The hyper-parameters in the order of their declaration, composite kernels depth first, e.g.
/// "factors.0.length_scales.1". Pointers into `kernel`. Throws std::invalid_argument for more than kMaxHyperParameters.
struct HyperParameter {
  std::string name;   // path inside the kernel
  std::string field;  // name of the declared field
  double* value = nullptr;
};
std::vector<HyperParameter> hyper_parameters(Kernel& kernel);

/// Throws std::invalid_argument unless every kernel inside has one length scale per input dimension.
void require_dimension(const Kernel& kernel, int dimension);

/// What is wrong with `kernel` for inputs of this dimension, in words; empty when nothing is.
std::string dimension_problem(const Kernel& kernel, int dimension);

}  // namespace bayesctrl
