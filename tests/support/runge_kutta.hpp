#pragma once

#include <array>
#include <cstddef>

namespace bayesctrl::testing {

/// The state after `h` seconds by one classical Runge-Kutta step of its own equations, rate(state, time since its
/// beginning): what machines are written out with, independently of the library.
template <std::size_t kCount>
std::array<double, kCount> runge_kutta_step(const std::array<double, kCount>& x, double h, auto&& rate) {
  using State = std::array<double, kCount>;
  const auto along = [&x](const State& slope, double by) {
    State moved = x;
    for (std::size_t i = 0; i < kCount; ++i) moved[i] += by * slope[i];
    return moved;
  };
  const State k1 = rate(x, 0.0), k2 = rate(along(k1, 0.5 * h), 0.5 * h), k3 = rate(along(k2, 0.5 * h), 0.5 * h);
  const State k4 = rate(along(k3, h), h);
  State next = x;
  for (std::size_t i = 0; i < kCount; ++i) next[i] += h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
  return next;
}

}  // namespace bayesctrl::testing
