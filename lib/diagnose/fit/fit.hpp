#pragma once

#include "diagnose/fit/unknowns.hpp"
#include "diagnose/fit/window_start.hpp"
#include "diagnose/motion/linear_response.hpp"

namespace bayesctrl {

/// A model adjusted to recordings by free runs over windows whose initial states are free.
struct Fit {
  Plant plant;
  std::vector<Effect> effects;
  std::vector<Unknown> unknowns;
  Eigen::MatrixXd covariance;        // of the unknowns, posterior
  std::vector<WindowStart> starts;   // one per window
  Eigen::VectorXd residual;          // rows of the response: measured less simulated, in units of the noise
  double squares = kInfinity;        // of the residual
  bool refined = false;              // with slopes from the machine itself
  double log_evidence = -kInfinity;  // Laplace, up to a constant of the recordings; penalty per effect included

  /// Posterior standard deviation of a parameter of an effect (-1: of the plant); 0 for what is not adjusted.
  double deviation(int effect, std::string_view name) const;
};

/// Values of a fit's unknowns; the same put into its plant and effects, as far as the effects admit them; one of them.
Eigen::VectorXd values_of(const Fit& fit);
void assign(Fit& fit, const Eigen::VectorXd& values);
void put(Fit& fit, const Unknown& unknown);

/// Minus twice the logarithm of the prior, and minus half the slope of that; the curvature of half the squares and the
/// prior, for slopes of the rows (rows x unknowns).
double prior_cost(const Fit& fit);
Eigen::VectorXd prior_slope(const Fit& fit);
Eigen::MatrixXd information(const Eigen::MatrixXd& slopes, const Fit& fit);

/// What all fits of a diagnosis share.
struct FitProblem {
  Plant nominal;  // where fits begin
  Plant given;    // about which free parameters are likely to be
  std::vector<std::string> free;
  const std::vector<Measured>& data;
  const LinearResponse& response;
  const Excitation& excitation;
  double penalty = 3.0;     // nats per effect
  double max_step = 0.011;  // s, of the integration
  double best = kInfinity;  // squares of the best fit so far
};

/// Covariance and evidence of a fit, by Laplace's approximation.
void weigh(const FitProblem& problem, Fit& fit, const Eigen::MatrixXd& slopes);

/// Longest step of the integration (s) that moves simulations by less than a twentieth of the noise.
double adequate_step(const FitProblem& problem);

/// Most probable parameters by damped Gauss-Newton steps: residuals from free runs of the machine, slopes from the
/// linear response and, where those mislead, from the machine itself. `effects` is the start, with `starts` those of
/// the windows as another fit has found them. Throws NumericalError when not even the start can be simulated.
Fit fit(const FitProblem& problem, std::vector<Effect> effects, const std::vector<WindowStart>& starts = {});

/// The starts and the residual of a fit whose parameters others have settled. Throws NumericalError.
Fit started(const FitProblem& problem, Fit fit);

/// Squares of the residual there, before anything is adjusted.
double squares_at(const FitProblem& problem, std::vector<Effect> effects, const std::vector<WindowStart>& starts);

/// The same from where a fit is, with slopes from the machine itself.
Fit refined(const FitProblem& problem, Fit fit);

/// Measured less simulated positions of a fit, per window (samples x joints).
std::vector<Eigen::MatrixXd> rests(const FitProblem& problem, const Fit& fit);

/// Simulated motion of a fit over its windows, elsewhere what `elsewhere` says.
std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere);

}  // namespace bayesctrl
