#pragma once

#include <algorithm>
#include <array>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "numerics/integrate.hpp"

namespace bayesctrl {

/// Integrates y' = f(y, t) from t0 to t1 in place; `f(y, dydt, t)` writes the derivative. `step` is the step size to
/// try first and, on return, the one to try next (the last is not shortened by t1). Allocates nothing. Throws
/// NumericalError when y stops being finite or more than `max_steps` steps are needed.
template <std::size_t N>
void integrate(auto&& f, std::array<double, N>& y, double t0, double t1, const Integration& options, double& step) {
  namespace odeint = boost::numeric::odeint;
  using Stepper = odeint::runge_kutta_dopri5<std::array<double, N>>;
  using Control = odeint::controlled_runge_kutta<Stepper>;
  Control stepper(typename Control::error_checker_type(options.absolute_tolerance, options.relative_tolerance));
  const double rounding = 1e-12 * (t1 - t0);
  double t = t0;
  int steps = 0;
  while (t1 - t > rounding) {
    double trial = std::min(step, t1 - t);
    const bool shortened = trial < step;
    if (stepper.try_step(f, y, t, trial) == odeint::success) {
      step = shortened ? std::max(step, trial) : trial;
    } else {
      step = trial;
    }
    if (++steps > options.max_steps || !(step > 1e-15 * std::max(1.0, std::abs(t)))) {
      throw NumericalError("the integration stalls at t = " + format(t, 6) + " s");
    }
    for (const double value : y) {
      if (!std::isfinite(value)) throw NumericalError("the state diverges at t = " + format(t, 6) + " s");
    }
  }
}

}  // namespace bayesctrl
