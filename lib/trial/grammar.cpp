#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "trial/draws.hpp"
#include "trial/machine_draw.hpp"

namespace bayesctrl::trial {

namespace {

/// A function of one number of about -1 to 1, and how it is called.
struct Shape {
  std::string name;
  std::function<double(double)> value;
};

template <std::size_t N>
std::size_t choose(const std::array<double, N>& weights, RandomStream& random) {
  double left = draw_uniform(random, 0.0, 1.0);
  for (std::size_t i = 0; i + 1 < N; ++i) {
    if (left < weights[i]) return i;
    left -= weights[i];
  }
  return N - 1;
}

Shape draw_shape(RandomStream& random) {
  std::array<double, 3> a{}, c{}, w{};
  for (std::size_t i = 0; i < 3; ++i) {
    a[i] = draw_normal(random);
    c[i] = draw_uniform(random, -0.8, 0.8);
    w[i] = draw_uniform(random, 0.15, 0.6);
  }
  const double k = draw_uniform(random, 3.0, 9.0), p = draw_uniform(random, 0.3, 2.5);
  switch (choose<5>({0.3, 0.25, 0.15, 0.15, 0.15}, random)) {
    case 0:
      return {"smooth", [=](double x) {
                double sum = 0.0;
                for (std::size_t i = 0; i < 3; ++i) sum += a[i] * std::exp(-0.5 * std::pow((x - c[i]) / w[i], 2));
                return sum;
              }};
    case 1:
      return {"kinked", [=](double x) {
                double sum = 0.0;
                for (std::size_t i = 0; i < 3; ++i) sum += a[i] * std::max(0.0, x - c[i]);
                return sum;
              }};
    case 2:
      return {"saturating", [=](double x) { return std::tanh((x - c[0]) / w[0]); }};
    case 3:
      return {"rippling", [=](double x) { return std::sin(k * x + 3.0 * c[0]); }};
    default:
      return {"power", [=](double x) { return std::copysign(std::pow(std::abs(x), p), x); }};
  }
}

}  // namespace

Invention draw_invention(double range, double speed, double input, double duration, RandomStream& random) {
  static constexpr std::array<std::string_view, 5> kVariables{"position", "velocity", "input", "time", "history"};
  const auto scaled = [=](std::size_t variable, double q, double v, double u, double t, double m) {
    switch (variable) {
      case 0:
        return q / range;
      case 1:
        return v / speed;
      case 2:
        return u / std::max(input, 1e-9);
      case 3:
        return 2.0 * t / duration - 1.0;
      default:
        return m;
    }
  };
  // What is remembered: a function of another variable that fades, or the way, up to a yield (Bouc 1967).
  const std::size_t of = choose<3>({0.3, 0.4, 0.3}, random);
  const bool yields = draw_uniform(random, 0.0, 1.0) < 0.4;
  const double fades = log_uniform(random, 0.1, 5.0), way = draw_uniform(random, 0.05, 0.3) * range,
               sharp = draw_uniform(random, 1.0, 3.0);
  const Shape kept = draw_shape(random);
  const auto rate = [=](double q, double v, double u, double m) {
    if (yields) return (v - std::abs(v) * std::copysign(std::pow(std::abs(m), sharp), m)) / way;
    return (kept.value(scaled(of, q, v, u, 0.0, 0.0)) - m) / fades;
  };
  const std::size_t first = choose<5>({0.25, 0.25, 0.2, 0.1, 0.2}, random);
  std::size_t second = first;
  while (second == first) second = choose<5>({0.25, 0.25, 0.2, 0.1, 0.2}, random);
  const bool product = draw_uniform(random, 0.0, 1.0) < 0.5;
  const Shape one = draw_shape(random), other = draw_shape(random);
  const auto called = [&](const Shape& shape, std::size_t variable) {
    const std::string inner = yields ? "yield of the way" : "faded " + kept.name + " " + std::string(kVariables[of]);
    return shape.name + " " + (variable == 4 ? inner : std::string(kVariables[variable]));
  };
  return {called(one, first) + (product ? " times " + called(other, second) : ""), std::string(kVariables[first]),
          [=](double q, double v, double u, double t, double m) {
            const double value = one.value(scaled(first, q, v, u, t, m));
            return product ? value * other.value(scaled(second, q, v, u, t, m)) : value;
          },
          rate, product ? std::string(kVariables[second]) : ""};
}

}  // namespace bayesctrl::trial
