#include "diagnose/fit/autoregression.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

Measured curve(const std::function<double(double)>& position) {
  Measured m;
  m.position.resize(1200, 1);
  m.input = Eigen::MatrixXd::Zero(1200, 1);
  for (int k = 0; k < 1200; ++k) {
    m.time.push_back(0.01 * k);
    m.position(k, 0) = position(0.01 * k);
  }
  return m;
}

}  // namespace

TEST_CASE("Without physics a swing is predicted, and what nobody can know is not", "[fit]") {
  const auto swing = [](double t) { return std::exp(-0.1 * t) * std::sin(3.0 * t + 1.0) + 0.3; };
  const auto later = [&](double t) { return 0.7 * (swing(t + 0.4) - 0.3) + 0.3; };
  CHECK(autoregression_error({curve(swing)}, {curve(later)}, 1.0) < 1e-4);
  RandomStream random(1);
  const auto noise = [&](double) { return draw_normal(random); };
  CHECK(autoregression_error({curve(noise)}, {curve(noise)}, 1.0) == Approx(1.0).epsilon(0.1));
}

TEST_CASE("Where an autoregression runs away the mean is what is predicted", "[fit]") {
  const auto grows = [](double t) { return std::exp(2.0 * t); };
  const auto rests = [](double t) { return std::floor(0.9 * t) + 0.1 * std::sin(40.0 * t); };
  const double error = autoregression_error({curve(grows)}, {curve(rests)}, 1.0);
  CHECK(error > 0.05);
  CHECK(error < 0.6);
}
