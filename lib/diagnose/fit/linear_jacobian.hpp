#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// Jacobian of a fit's rows by its unknowns (rows x unknowns) from the linear response about the measured motion.
Eigen::MatrixXd linear_jacobian(const FitProblem& problem, const Fit& fit);

/// Gives every unknown its prior: one without a deviation of its own that at which the parameter, from where it is,
/// moves as much as the prior of a torque allows.
void complete_priors(const FitProblem& problem, Fit& fit);

}  // namespace bayesctrl
