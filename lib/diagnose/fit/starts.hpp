#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// Share of the squares below which a better start must bring them, or the rest is adjusted once more.
inline constexpr double kMuch = 0.5;

/// What so many rows of noise leave at most.
double usual_squares(Eigen::Index rows);

/// Simulates, moves the starts to where they explain the rest best by the linear response, simulates again; `rounds`
/// times. Throws NumericalError.
void simulate(const FitProblem& problem, Fit& fit, int rounds);

/// Windows in which the linear response misjudges the start (a joint sticks, the motion is unstable, or more than
/// position and velocity is unknown): their starts once more, with slopes from the machine itself.
void polish(const FitProblem& problem, Fit& fit);

/// Where few windows leave far more than the others, their starts may have been found with parameters that were far
/// off: these once more, from there and from where the motion is. Whether most of what was left is gone.
bool recover(const FitProblem& problem, Fit& fit);

}  // namespace bayesctrl
