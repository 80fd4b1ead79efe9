#include "gp/kernel.hpp"

#include <stdexcept>

namespace bayesctrl {

namespace {

constexpr double kNegligible = 1e-100;  // of the variance: nothing that double precision could tell from zero

template <class Form>
inline constexpr bool kIsComposite = std::is_same_v<Form, Sum> || std::is_same_v<Form, Product>;

const std::vector<Kernel>& parts(const Sum& sum) { return sum.terms; }
const std::vector<Kernel>& parts(const Product& product) { return product.factors; }

/// Hyper-parameters of a kernel that is not composite.
int parameter_count(const auto& form) {
  int count = 0;
  const auto add = [&count](std::string_view, const auto& value, const Info&) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      ++count;
    } else {
      count += static_cast<int>(value.size());
    }
  };
  std::decay_t<decltype(form)>::fields(form, add);
  return count;
}

void differentiate_composite(const auto& form, const InputBlock& inputs, const double* x, BlockArray& k,
                             BlockGradient& gradient) {
  constexpr bool kSum = std::is_same_v<std::decay_t<decltype(form)>, Sum>;
  differentiate(parts(form)[0], inputs, x, k, gradient);
  for (std::size_t i = 1; i < parts(form).size(); ++i) {
    BlockArray other;
    BlockGradient other_gradient;
    differentiate(parts(form)[i], inputs, x, other, other_gradient);
    if (!kSum) gradient.colwise() *= other;
    if (!kSum) other_gradient.colwise() *= k;
    const Eigen::Index before = gradient.cols();
    gradient.conservativeResize(Eigen::NoChange, before + other_gradient.cols());
    gradient.rightCols(other_gradient.cols()) = other_gradient;
    if (kSum) {
      k += other;
    } else {
      k *= other;
    }
  }
}

void collect(Kernel& kernel, const std::string& prefix, std::vector<HyperParameter>& list) {
  const auto add = [&](std::string_view name, auto& value, const Info&) {
    using T = std::decay_t<decltype(value)>;
    const std::string path = prefix + std::string(name);
    if constexpr (std::is_same_v<T, double>) {
      list.push_back({path, std::string(name), &value});
    } else if constexpr (std::is_same_v<T, std::vector<double>>) {
      for (std::size_t i = 0; i < value.size(); ++i) {
        list.push_back({path + "." + std::to_string(i), std::string(name), &value[i]});
      }
    } else {
      for (std::size_t i = 0; i < value.size(); ++i) collect(value[i], path + "." + std::to_string(i) + ".", list);
    }
  };
  std::visit([&](auto& form) { std::decay_t<decltype(form)>::fields(form, add); }, kernel.form);
}

}  // namespace

double correlation(const Kernel& kernel, std::span<const double> x, std::span<const double> y) {
  BlockArray k;
  evaluate(kernel, {x.data(), 1, 1, static_cast<int>(x.size())}, y.data(), k);
  return k[0] / variance(kernel);
}

double variance(const Kernel& kernel) {
  return std::visit(
      [](const auto& form) {
        using Form = std::decay_t<decltype(form)>;
        if constexpr (kIsComposite<Form>) {
          double result = std::is_same_v<Form, Sum> ? 0.0 : 1.0;
          for (const Kernel& part : parts(form)) {
            result = std::is_same_v<Form, Sum> ? result + variance(part) : result * variance(part);
          }
          return result;
        } else {
          return form.variance();
        }
      },
      kernel.form);
}

void scale_output(Kernel& kernel, double factor) {
  std::visit(
      [&](auto& form) {
        using Form = std::decay_t<decltype(form)>;
        if constexpr (std::is_same_v<Form, Sum>) {
          for (Kernel& term : form.terms) scale_output(term, factor);
        } else if constexpr (std::is_same_v<Form, Product>) {
          scale_output(form.factors.front(), factor);
        } else {
          form.output_scale *= factor;
        }
      },
      kernel.form);
}

void evaluate(const Kernel& kernel, const InputBlock& inputs, const double* x, BlockArray& k) {
  std::visit(
      [&](const auto& form) {
        using Form = std::decay_t<decltype(form)>;
        if constexpr (kIsComposite<Form>) {
          evaluate(parts(form)[0], inputs, x, k);
          for (std::size_t i = 1; i < parts(form).size(); ++i) {
            BlockArray other;
            evaluate(parts(form)[i], inputs, x, other);
            if constexpr (std::is_same_v<Form, Sum>) {
              k += other;
            } else {
              k *= other;
            }
          }
        } else {
          form.evaluate(inputs, x, k);
          // Far apart means independent: without this, products of such numbers are denormal and slow every solve.
          k = (k < kNegligible * form.variance()).select(0.0, k);  // NaN stays
        }
      },
      kernel.form);
}

void differentiate(const Kernel& kernel, const InputBlock& inputs, const double* x, BlockArray& k,
                   BlockGradient& gradient) {
  std::visit(
      [&](const auto& form) {
        if constexpr (kIsComposite<std::decay_t<decltype(form)>>) {
          differentiate_composite(form, inputs, x, k, gradient);
        } else {
          gradient.resize(inputs.count, parameter_count(form));
          form.differentiate(inputs, x, k, gradient);
        }
      },
      kernel.form);
}

std::vector<HyperParameter> hyper_parameters(Kernel& kernel) {
  std::vector<HyperParameter> list;
  collect(kernel, "", list);
  if (list.size() > kMaxHyperParameters) {
    throw std::invalid_argument("a kernel has " + std::to_string(list.size()) + " hyper-parameters, at most " +
                                std::to_string(kMaxHyperParameters) + " are possible");
  }
  return list;
}

std::string dimension_problem(const Kernel& kernel, int dimension) {
  return std::visit(
      [&](const auto& form) -> std::string {
        using Form = std::decay_t<decltype(form)>;
        if constexpr (kIsComposite<Form>) {
          for (const Kernel& part : parts(form)) {
            if (std::string problem = dimension_problem(part, dimension); !problem.empty()) return problem;
          }
        } else if (static_cast<int>(form.length_scales.size()) != dimension) {
          return std::string(Form::kName) + " has " + std::to_string(form.length_scales.size()) +
                 " length_scales, but the input has " + std::to_string(dimension) + " dimensions";
        }
        return "";
      },
      kernel.form);
}

void require_dimension(const Kernel& kernel, int dimension) {
  if (const std::string problem = dimension_problem(kernel, dimension); !problem.empty()) {
    throw std::invalid_argument(problem);
  }
}

}  // namespace bayesctrl
