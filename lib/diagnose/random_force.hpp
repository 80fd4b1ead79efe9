#pragma once

#include "diagnose/fit.hpp"

namespace bayesctrl {

/// The most probable parameters of a fit, with their covariance, if a random force (white, of the most probable
/// intensity) acts beside the model. Effects are evaluated along the measured motion, for with such a force the machine
/// is where it was measured and not where the model alone would take it; `problem` is linearised about that motion.
/// Where a model leaves far more than noise, free runs alone would give its parameters deviations that are far too
/// small, and values that depend on where it sticks in vain.
Fit beside_random_force(const FitProblem& problem, Fit fit);

}  // namespace bayesctrl
