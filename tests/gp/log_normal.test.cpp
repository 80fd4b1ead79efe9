#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "base/random.hpp"
#include "gp/process.hpp"

using namespace bayesctrl;

namespace {

/// The variance of b as the paper prints it below its equation for the mean of b.
double printed_variance(double m, double s2) { return std::exp(2.0 * m + s2) * std::exp(s2 - 1.0); }

/// Sample mean and variance of exp(f), each with its standard error.
struct Sampled {
  double mean, mean_error, variance, variance_error;
};

Sampled sample_exponential(const Marginal& log_value, std::uint64_t seed) {
  constexpr int kDraws = 1'000'000;
  RandomStream random = random_stream(seed, "log-normal");
  const double sd = std::sqrt(log_value.variance);
  std::vector<double> values(kDraws);
  double mean = 0.0;
  for (double& value : values) {
    value = std::exp(log_value.mean + sd * draw_normal(random));
    mean += value / kDraws;
  }
  double second = 0.0, fourth = 0.0;
  for (const double value : values) {
    const double square = (value - mean) * (value - mean);
    second += square / kDraws;
    fourth += square * square / kDraws;
  }
  return {mean, std::sqrt(second / kDraws), second, std::sqrt((fourth - second * second) / kDraws)};
}

}  // namespace

TEST_CASE("Mean and variance of exp(f) are those of a million draws", "[gp]") {
  for (const Marginal& log_value :
       {Marginal{0.0, 0.01}, Marginal{-1.4, 0.1}, Marginal{0.7, 0.25}, Marginal{0.2, 0.5}}) {
    const Sampled sampled = sample_exponential(log_value, 1);
    const Marginal value = exponential_of(log_value);
    INFO("m = " << log_value.mean << ", s2 = " << log_value.variance);
    CHECK(std::abs(value.mean - sampled.mean) < 4.0 * sampled.mean_error);
    CHECK(std::abs(value.variance - sampled.variance) < 4.0 * sampled.variance_error);
  }
}

// exp(m + s2/2) and exp(2m + s2)(exp(s2) - 1) by mpmath with 30 digits.
TEST_CASE("Mean and variance of exp(f) have their closed forms", "[gp]") {
  const Marginal value = exponential_of({0.3, 0.5});
  CHECK(value.mean == Approx(1.73325301786739523682).epsilon(1e-14));
  CHECK(value.variance == Approx(1.94886640044868169160).epsilon(1e-14));
}

TEST_CASE("For a vanishing variance exp(f) is exp(m), with a variance in proportion", "[gp]") {
  for (const double m : {-2.0, 0.0, 1.5}) {
    CHECK(exponential_of({m, 0.0}).mean == std::exp(m));
    CHECK(exponential_of({m, 0.0}).variance == 0.0);
    for (const double s2 : {1e-8, 1e-12, 1e-18, 1e-100}) {  // exp(s2) - 1 would be rounded away
      CHECK(exponential_of({m, s2}).mean == Approx(std::exp(m)).epsilon(s2 + 1e-15));
      CHECK(exponential_of({m, s2}).variance == Approx(std::exp(2.0 * m) * s2).epsilon(2.0 * s2 + 1e-14));
    }
  }
}

TEST_CASE("The variance of b that the paper prints is not that of a log-normal", "[gp]") {
  const Marginal log_value{0.7, 0.25};
  const Sampled sampled = sample_exponential(log_value, 2);
  CHECK(std::abs(printed_variance(0.7, 0.25) - sampled.variance) > 100.0 * sampled.variance_error);
  // It does not vanish with s2 either: a gain known exactly would keep the variance exp(2m - 1).
  CHECK(printed_variance(0.0, 0.0) == Approx(std::exp(-1.0)));
  CHECK(exponential_of({0.0, 0.0}).variance == 0.0);
}
