#pragma once

#include "diagnose/fit/segment_state.hpp"
#include "diagnose/fit/unknowns.hpp"
#include "diagnose/motion/linear_response.hpp"
#include "diagnose/motion/rests.hpp"
#include "diagnose/settings.hpp"
#include "numerics/least_squares.hpp"

namespace bayesctrl {

/// A model fitted to recordings by multiple shooting: free runs over segments (windows) whose initial states are free.
struct Fit {
  Plant plant;
  std::vector<Effect> effects;
  std::vector<Unknown> unknowns;
  Eigen::MatrixXd covariance;                // of the unknowns, posterior
  std::vector<SegmentState> initial_states;  // one per window
  Eigen::VectorXd residual;                  // rows of the response: measured less simulated, in units of the noise
  double sse = kInfinity;                    // of the residual
  bool refined = false;                      // with the exact Jacobian
  bool glanced = false;                      // one step only: what it leaves is lost
  double log_evidence = -kInfinity;          // Laplace, up to a constant of the recordings; penalty per effect included

  /// Posterior standard deviation of a parameter of an effect (-1: of the plant); 0 for what is not adjusted.
  double deviation(int effect, std::string_view name) const;
};

/// Whether a fit leaves so little that its linear response tells what is missing in it.
bool leaves_little(const Fit& fit);

/// Values of a fit's unknowns; the same put into its plant and effects, as far as the effects admit them; one of them.
Eigen::VectorXd values_of(const Fit& fit);
void assign(Fit& fit, const Eigen::VectorXd& values);
void put(Fit& fit, const Unknown& unknown);

/// Minus twice the logarithm of the prior, and minus half its gradient; the Gauss-Newton Hessian of half the SSE and
/// the prior for a Jacobian of the rows (rows x unknowns).
double prior_cost(const Fit& fit);
Eigen::VectorXd prior_gradient(const Fit& fit);
Eigen::MatrixXd information(const Eigen::MatrixXd& jacobian, const Fit& fit);

/// Cost of a fit about its unknowns' values, in nats, with their bounds.
QuadraticModel quadratic_model(const Eigen::MatrixXd& jacobian, const Fit& fit);

/// What all fits of a diagnosis share.
struct FitProblem {
  Plant nominal;  // where fits begin
  Plant given;    // about which free parameters are likely to be
  std::vector<std::string> free;
  const std::vector<Measured>& data;
  const LinearResponse& response;
  const Forcing& forcing;
  double penalty = 0.0;          // nats per effect
  double max_step = 0.011;       // s, of the integration
  double best = kInfinity;       // SSE of the best fit so far
  const Rests* rests = nullptr;  // at which dry friction may hold any torque; none: where it is not asked
};

/// Covariance and evidence of a fit, by Laplace's approximation.
void weigh(const FitProblem& problem, Fit& fit, const Eigen::MatrixXd& jacobian);

/// Longest step of the integration (s) that moves simulations by less than a twentieth of the noise.
double adequate_step(const FitProblem& problem);

/// Most probable parameters by damped Gauss-Newton steps: residuals from free runs of the machine, the Jacobian from
/// the linear response and, where that misleads, from the machine itself. `effects` is the start, with `starts` those
/// of the windows as another fit has found them. Throws NumericalError when not even the start can be simulated.
Fit fit(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts = {});

/// The same of a set that has begun.
Fit completed(const FitProblem& problem, Fit begun);

/// The same after one step of the linear response: whether a set is worth a fit. Throws NumericalError.
Fit glance(const FitProblem& problem, Fit begun);

/// Initial states and residual of a fit whose parameters are given. Throws NumericalError.
Fit started(const FitProblem& problem, Fit fit);

/// Starts of the windows for a fit's set: those that a fit of another has `found`, as far as both have them, else the
/// measured motion.
std::vector<SegmentState> window_starts(const FitProblem& problem, const Fit& fit,
                                        const std::vector<SegmentState>& found);

/// A set as it is given, its numbers within their bounds, before anything is simulated.
Fit unsimulated(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts);

/// The same with what it leaves, before anything is adjusted; without evidence. Throws NumericalError.
Fit begin(const FitProblem& problem, std::vector<Effect> effects, const std::vector<SegmentState>& starts);

/// The same from where a fit is, with the exact Jacobian.
Fit refined(const FitProblem& problem, Fit fit);

/// Measured less simulated positions of a fit, per window (samples x joints).
std::vector<Eigen::MatrixXd> residuals(const FitProblem& problem, const Fit& fit);

/// Simulated motion of a fit over its windows, elsewhere what `elsewhere` says.
std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere);

}  // namespace bayesctrl
