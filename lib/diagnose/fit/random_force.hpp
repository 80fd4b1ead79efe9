#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// A random force (white) beside a model that leaves far more than noise, where free runs alone would give parameters
/// deviations that are far too small, and values that depend on where the model sticks in vain. With such a force the
/// machine is where it was measured and not where the model would take it, so effects are evaluated along the measured
/// motion: `problem` is linearised about that (stochastic grey-box models: Kristensen, Madsen & Jorgensen 2004).

/// The most probable parameters of a fit with their covariance and evidence; `residual` and `squares` are those of the
/// whitened rows. `white`: the problem's response beside a random acceleration.
Fit beside_random_force(const FitProblem& problem, const LinearResponse& white, Fit fit);

/// The intensity of that acceleration, per joint, that is most probable together with the fit's parameters.
Eigen::VectorXd likely_intensity(const FitProblem& problem, Fit fit);

}  // namespace bayesctrl
