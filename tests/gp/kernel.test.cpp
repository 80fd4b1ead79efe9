#include "gp/kernel.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/dense_gp.hpp"
#include "support/families.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

constexpr double kKernelRoundOff = 1e-13;  // of k, relative to the variance: some dozens of operations
constexpr double kKernelDifference =
    1e-8;  // of a central difference with step 1e-3, extrapolated: 1e-12 + 1e-16 / 1e-3

/// All inputs of the block, with k and its gradient.
struct Differentiated {
  BlockArray k;
  BlockGradient gradient;
};

Differentiated differentiated(const Kernel& kernel, const Eigen::MatrixXd& inputs, const Eigen::VectorXd& x) {
  Differentiated result;
  const auto rows = static_cast<int>(inputs.rows());
  differentiate(kernel, InputBlock{inputs.data(), rows, rows, static_cast<int>(inputs.cols())}, x.data(), result.k,
                result.gradient);
  return result;
}

}  // namespace

// The formulas of Rasmussen & Williams 2006 (4.9, 4.17, 4.19, 4.31) evaluated by mpmath with 30 digits at x - y = (0.8,
// -1.6).
TEST_CASE("Each kernel has the value of its formula", "[gp]") {
  const Eigen::Vector2d x(0.3, -1.2), y(-0.5, 0.4);
  const std::vector<double> scales{0.9, 2.3};
  const std::vector<std::pair<Kernel, double>> expected{
      {{SquaredExponential{1.7, scales}}, 1.5284112545733315058252109164},
      {{RationalQuadratic{1.7, scales, 1.4}}, 1.70954833193488054314678196607},
      {{Matern32{1.7, scales}}, 1.2089246669303912252002900784},
      {{Matern52{1.7, scales}}, 1.30800758364432815819261886894},
      {{Periodic{1.7, scales, {2.0, 5.5}}}, 0.244341088875643821703733330706}};
  for (const auto& [kernel, value] : expected) {
    INFO(name_of(kernel.form));
    CHECK(covariance(kernel, x, y) == Approx(value).epsilon(kKernelRoundOff));
  }
  const Kernel sum{Sum{{expected[0].first, expected[4].first}}},
      product{Product{{expected[0].first, expected[4].first}}};
  CHECK(covariance(sum, x, y) == Approx(expected[0].second + expected[4].second).epsilon(kKernelRoundOff));
  CHECK(covariance(product, x, y) == Approx(expected[0].second * expected[4].second).epsilon(kKernelRoundOff));
}

TEST_CASE("Every kernel is symmetric and has its variance at distance zero", "[gp]") {
  for (const int dimension : {1, 2, 3}) {
    const Eigen::MatrixXd points = random_points(20, dimension, 3.0, 1);
    for (const auto& [name, kernel] : example_kernels(dimension)) {
      const Eigen::MatrixXd k = gram(kernel, points, points);
      const double scale = variance(kernel);
      INFO(name << " in " << dimension << " dimensions");
      CHECK(k.isApprox(k.transpose(), kKernelRoundOff));
      CHECK(largest_difference(k.diagonal(), Eigen::VectorXd::Constant(20, scale)) < kKernelRoundOff * scale);
      CHECK(k.cwiseAbs().maxCoeff() <= scale * (1.0 + kKernelRoundOff));
      CHECK((k.array() > 0.0).all());
      const Eigen::VectorXd x = points.row(3), y = points.row(7);
      CHECK(correlation(kernel, span_of(x), span_of(y)) == Approx(k(3, 7) / scale).epsilon(kKernelRoundOff));
    }
  }
}

TEST_CASE("Every kernel is positive semidefinite", "[gp]") {
  constexpr int kPoints = 60;
  for (const double reach : {0.3, 3.0, 30.0}) {  // strongly to hardly correlated
    const Eigen::MatrixXd points = random_points(kPoints, 2, reach, 2);
    for (const auto& [name, kernel] : example_kernels(2)) {
      const Eigen::MatrixXd k = gram(kernel, points, points);
      const Eigen::VectorXd eigenvalues = testing::dense::eigenvalues(k);
      INFO(name << " within " << reach);
      CHECK(eigenvalues.minCoeff() > -kPoints * kKernelRoundOff * variance(kernel));
    }
  }
}

TEST_CASE("The gradient of every kernel equals central differences for every hyper-parameter", "[gp]") {
  for (const int dimension : {1, 2, 3}) {
    Eigen::MatrixXd inputs = random_points(17, dimension, 2.0, 3);
    const Eigen::VectorXd x = random_points(1, dimension, 2.0, 4).row(0);
    inputs.row(5) = x.transpose();  // distance zero, where a root is not differentiable
    for (const auto& [name, kernel] : example_kernels(dimension)) {
      const Differentiated result = differentiated(kernel, inputs, x);
      Kernel moved = kernel;
      const std::vector<HyperParameter> parameters = hyper_parameters(moved);
      REQUIRE(result.gradient.cols() == static_cast<Eigen::Index>(parameters.size()));
      REQUIRE(result.gradient.rows() == inputs.rows());
      for (std::size_t p = 0; p < parameters.size(); ++p) {
        const double value = *parameters[p].value;
        for (Eigen::Index i = 0; i < inputs.rows(); ++i) {
          const Eigen::VectorXd y = inputs.row(i);
          const double expected = derivative(
              [&](double log_value) {
                *parameters[p].value = std::exp(log_value);
                return covariance(moved, x, y);
              },
              std::log(value), 1e-3);
          INFO(name << " by " << parameters[p].name << " at input " << i);
          REQUIRE(relative_error(result.gradient(i, static_cast<Eigen::Index>(p)), expected, variance(kernel)) <
                  kKernelDifference);
        }
        *parameters[p].value = value;
      }
    }
  }
}

TEST_CASE("Differentiating gives the value as well", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(kBlock, 2, 3.0, 5);
  const Eigen::VectorXd x = random_points(1, 2, 3.0, 6).row(0);
  for (const auto& [name, kernel] : example_kernels(2)) {
    const Differentiated result = differentiated(kernel, inputs, x);
    BlockArray k;
    evaluate(kernel, InputBlock{inputs.data(), kBlock, kBlock, 2}, x.data(), k);
    INFO(name);
    CHECK(largest_difference(result.k.matrix(), k.matrix()) < kKernelRoundOff * variance(kernel));
  }
}

TEST_CASE("Evaluated in a block of any size, a kernel is what it is for one input", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(kBlock, 2, 3.0, 7);
  const Eigen::VectorXd x = random_points(1, 2, 3.0, 8).row(0);
  for (const auto& [name, kernel] : example_kernels(2)) {
    const Eigen::VectorXd single = gram(kernel, inputs, x.transpose()).col(0);
    for (const int count : {1, 2, 3, 4, 5, 63, 64}) {
      BlockArray k;
      evaluate(kernel, InputBlock{inputs.data(), kBlock, count, 2}, x.data(), k);
      INFO(name << ", block of " << count);
      CHECK(largest_difference(k.matrix(), single.head(count)) < kKernelRoundOff * variance(kernel));
    }
  }
}

TEST_CASE("An input with an infinite length scale does not matter", "[gp]") {
  const Eigen::MatrixXd inputs = random_points(9, 3, 2.0, 9);
  const Eigen::VectorXd x = random_points(1, 3, 2.0, 10).row(0);
  for (const int ignored : {0, 1, 2}) {
    Eigen::MatrixXd moved = inputs;
    moved.col(ignored).array() = 1e3 * moved.col(ignored).array() + 17.0;
    for (auto [name, kernel] : example_kernels(3)) {
      std::vector<Eigen::Index> scales;
      Eigen::Index index = 0;
      for (const HyperParameter& parameter : hyper_parameters(kernel)) {
        if (parameter.field == "length_scales" && parameter.name.ends_with("." + std::to_string(ignored))) {
          *parameter.value = kInfinity;
          scales.push_back(index);
        }
        ++index;
      }
      INFO(name << " ignoring input " << ignored);
      REQUIRE_FALSE(scales.empty());
      const Differentiated here = differentiated(kernel, inputs, x), there = differentiated(kernel, moved, x);
      CHECK(largest_difference(here.k.matrix(), there.k.matrix()) == 0.0);
      CHECK(here.gradient.allFinite());
      for (const Eigen::Index scale : scales) CHECK(here.gradient.col(scale).isZero(0.0));
    }
  }
}

TEST_CASE("A rational quadratic of large shape tends to the squared exponential", "[gp]") {
  const Eigen::Vector2d x(0.3, -1.2), y(-0.5, 0.4);
  const double limit = covariance({SquaredExponential{1.7, {0.9, 2.3}}}, x, y);
  const auto distance = [&](double shape) {
    return std::abs(covariance({RationalQuadratic{1.7, {0.9, 2.3}, shape}}, x, y) - limit);
  };
  CHECK(distance(1e8) < 1e-7);
  CHECK(distance(1e3) / distance(1e4) == Approx(10.0).epsilon(0.01));  // first order in 1 / shape
}

TEST_CASE("A periodic kernel returns after each of its periods", "[gp]") {
  const Kernel kernel{Periodic{1.3, {0.8, 1.1}, {2.0, 5.0}}};
  const Eigen::Vector2d x(0.3, -1.2), y(-0.5, 0.4);
  const double here = covariance(kernel, x, y);
  CHECK(covariance(kernel, x, y + Eigen::Vector2d(2.0, 0.0)) == Approx(here).epsilon(kKernelRoundOff));
  CHECK(covariance(kernel, x, y + Eigen::Vector2d(-6.0, 10.0)) == Approx(here).epsilon(kKernelRoundOff));
  CHECK(std::abs(covariance(kernel, x, y + Eigen::Vector2d(1.0, 0.0)) - here) > 0.1);
}

TEST_CASE("Far apart means independent, and no value is denormal", "[gp]") {
  const Eigen::Vector2d x(0.0, 0.0), y(80.0, 0.0);
  CHECK(covariance({SquaredExponential{1.0, {1.0, 1.0}}}, x, y) == 0.0);
  CHECK(covariance({RationalQuadratic{1.0, {1.0, 1.0}, 1.0}}, x, y) == Approx(1.0 / 3201.0));  // a heavy tail stays
}

TEST_CASE("What is asked at no number is no number", "[gp]") {
  const Eigen::Vector2d x(0.0, 0.0), y(std::nan(""), 0.0);
  for (const auto& [name, kernel] : example_kernels(2)) {
    INFO(name);
    CHECK(std::isnan(covariance(kernel, x, y)));
  }
}

TEST_CASE("Hyper-parameters are listed by path, composite kernels depth first", "[gp]") {
  Kernel kernel{Sum{{{Product{{{Periodic{}}, {SquaredExponential{}}}}}, {RationalQuadratic{}}}}};
  std::vector<std::string> paths;
  for (const HyperParameter& parameter : hyper_parameters(kernel)) paths.push_back(parameter.name);
  CHECK(paths == std::vector<std::string>{"terms.0.factors.0.output_scale", "terms.0.factors.0.length_scales.0",
                                          "terms.0.factors.0.length_scales.1", "terms.0.factors.0.periods.0",
                                          "terms.0.factors.0.periods.1", "terms.0.factors.1.output_scale",
                                          "terms.0.factors.1.length_scales.0", "terms.0.factors.1.length_scales.1",
                                          "terms.1.output_scale", "terms.1.length_scales.0", "terms.1.length_scales.1",
                                          "terms.1.shape"});
  *hyper_parameters(kernel)[11].value = 7.5;
  CHECK(std::get<RationalQuadratic>(std::get<Sum>(kernel.form).terms[1].form).shape == 7.5);
}

TEST_CASE("A kernel with too many hyper-parameters, or for another dimension, is refused in words", "[gp]") {
  Kernel wide{Sum{std::vector<Kernel>(11, Kernel{SquaredExponential{}})}};
  CHECK_THROWS_WITH(hyper_parameters(wide), "a kernel has 33 hyper-parameters, at most 32 are possible");
  for (const auto& [name, kernel] : example_kernels(3)) {
    INFO(name);
    CHECK(dimension_problem(kernel, 3).empty());
    CHECK_THAT(dimension_problem(kernel, 2), Catch::EndsWith("has 3 length_scales, but the input has 2 dimensions"));
    CHECK_THROWS_AS(require_dimension(kernel, 4), std::invalid_argument);
  }
  CHECK(Sum{}.problem() == "sum needs at least one kernel in terms");
  CHECK(Product{}.problem() == "product needs at least one kernel in factors");
  CHECK(Periodic{1.0, {1.0, 1.0}, {1.0}}.problem() == "periodic needs as many periods as length_scales");
}
