#pragma once

#include "diagnose/fit/fit.hpp"
#include "diagnose/motion/likely_intensity.hpp"

namespace bayesctrl {

/// White process noise in a model that leaves far more than sensor noise, where free runs alone would give parameters
/// deviations that are far too small, and values that depend on where the model sticks and the machine does not. With
/// process noise the machine is where it was measured and not where the model would take it, so effects are evaluated
/// along the measured motion: `problem` is linearised about that (stochastic grey-box models: Kristensen, Madsen &
/// Jorgensen 2004).

/// A problem whose response has process noise.
FitProblem beside(const FitProblem& problem, const LinearResponse& white);

/// A set as it is given, along the measured motion: nothing is simulated. `residual` and `sse` are those of the
/// problem's response, which may be without process noise: what the set does not explain of where the machine was.
Fit begin_along_motion(const FitProblem& problem, std::vector<Effect> effects);

/// What a fit's unknowns do to what it explains along the motion, per unit: rows of the response x unknowns.
Eigen::MatrixXd jacobian_along_motion(const FitProblem& problem, const Fit& fit);

/// The most probable parameters of a fit with their covariance and evidence, that of the intensity included; `residual`
/// and `sse` are those of the whitened rows. `white`: the problem's response with process noise.
Fit fit_with_process_noise(const FitProblem& problem, const LinearResponse& white, Fit fit);

/// The intensity of that noise, per joint, that is most probable together with the fit's parameters. `likely`: of the
/// problem's response.
Eigen::VectorXd likely_intensity(const FitProblem& problem, const LikelyIntensity& likely, Fit fit);

/// A fit beside noise of that intensity, which is its own: evidence of different models can be compared.
struct BesideNoise {
  LinearResponse white;
  Fit fit;

  /// Of each row.
  Eigen::VectorXd log_likelihood() const { return -0.5 * fit.residual.cwiseAbs2() - white.log_scale(); }
};
BesideNoise beside_likely_noise(const FitProblem& problem, const LikelyIntensity& likely, const Fit& fit);

}  // namespace bayesctrl
