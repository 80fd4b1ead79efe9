#pragma once

#include "base/fields.hpp"

namespace bayesctrl {

/// Adaptive Dormand-Prince 5(4), the method of MATLAB's ode45 that the paper used. Tolerances are per step.
/// The function itself is a template over the equation: `integrate` in numerics/detail/dormand_prince.hpp.
struct Integration {
  double relative_tolerance = 1e-8;
  double absolute_tolerance = 1e-10;
  int max_steps = 10'000;  // in one call: beyond that the equation is taken to be stiff or diverging

  static void fields(auto& self, auto&& field) {
    field("relative_tolerance", self.relative_tolerance,
          {between(1e-14, 1e-1), "", "of each step, relative to the state"});
    field("absolute_tolerance", self.absolute_tolerance, {between(1e-16, 1e-1), "", "of each step"});
    field("max_steps", self.max_steps, {between(1, 1e9), "", "steps in one control period before a run is given up"});
  }
  bool operator==(const Integration&) const = default;
};

}  // namespace bayesctrl
