#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// Slopes of a fit's rows by the linear response (rows x unknowns); settles priors that follow from what a parameter
/// does.
Eigen::MatrixXd linear_jacobian(const FitProblem& problem, Fit& fit);

}  // namespace bayesctrl
