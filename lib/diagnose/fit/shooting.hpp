#pragma once

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// The largest SSE that noise alone gives in so many rows.
double noise_sse(Eigen::Index rows);

/// Simulates all segments, moves their initial states to where they fit best by the linear response, simulates again;
/// `rounds` times, each segment for as long as that leaves less. Throws NumericalError, also if the segments leave
/// more than `most`; then it does not simulate all.
void simulate(const FitProblem& problem, Fit& fit, int rounds, double most = kInfinity);

/// Segments in which the linear response misjudges the initial state (a joint sticks, the motion is unstable, or more
/// than position and velocity is unknown): theirs by Levenberg-Marquardt on free runs.
void polish(const FitProblem& problem, Fit& fit);

/// Where few segments leave far more than the others, their initial states may have been found with parameters that
/// were far off: these once more, from there and from the measured motion. Whether most of the SSE is gone.
bool recover(const FitProblem& problem, Fit& fit);

}  // namespace bayesctrl
