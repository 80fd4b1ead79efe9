#pragma once

#include <functional>
#include <optional>

#include "diagnose/excitation.hpp"
#include "diagnose/linear_response.hpp"
#include "physics/machine.hpp"

namespace bayesctrl {

/// One number that a fit adjusts: a parameter of an effect or, with effect -1, a free parameter of the plant.
struct Unknown {
  int effect = -1;
  std::string name;
  double value = 0.0;
  double low = -kInfinity, high = kInfinity;
  double prior_mean = 0.0, prior_deviation = 1.0;
  double step = 1e-3;  // of differences
};

/// Numbers of a plant that `free` may name, and access to one of them.
std::vector<std::string> parameter_names(const Plant& plant);
double parameter(const Plant& plant, std::string_view name);
void set_parameter(Plant& plant, std::string_view name, double value);

/// Parameters of an effect by name.
double parameter(const EffectForm& form, std::string_view name);
void set_parameter(EffectForm& form, std::string_view name, double value);

/// A model adjusted to recordings by free runs over windows whose initial states are free.
struct Fit {
  Plant plant;
  std::vector<Effect> effects;
  std::vector<Unknown> unknowns;
  Eigen::MatrixXd covariance;               // of the unknowns, posterior
  std::vector<StateVector> initial_states;  // one per window
  Eigen::VectorXd residual;                 // rows of the response: measured less simulated, in units of the noise
  double squares = kInfinity;               // of the residual
  double log_evidence = -kInfinity;         // Laplace, up to a constant of the recordings; penalty per effect included

  /// Posterior standard deviation of a parameter of an effect (-1: of the plant); 0 for what is not adjusted.
  double deviation(int effect, std::string_view name) const;
};

/// What all fits of a diagnosis share.
struct FitProblem {
  Plant nominal;
  std::vector<std::string> free;
  const std::vector<Measured>& data;
  const LinearResponse& response;
  const Excitation& excitation;
  double penalty = 3.0;     // nats per effect
  double max_step = 0.011;  // s, of the integration
};

/// Longest step of the integration (s) that moves simulations by less than a twentieth of the noise.
double adequate_step(const FitProblem& problem);

/// Most probable parameters by damped Gauss-Newton steps: residuals from free runs of the machine, slopes from the
/// linear response. `effects` is the start. Throws NumericalError when not even the start can be simulated.
Fit fit(const FitProblem& problem, std::vector<Effect> effects, int iterations = 8);

/// Simulated motion of a fit over its windows, elsewhere what `elsewhere` says.
std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere);

/// Levenberg-Marquardt: the initial state [q, v] from `start` on that makes `rest` (samples x joints) smallest. A start
/// whose simulation diverges throws NumericalError.
StateVector fit_start(const std::function<Eigen::MatrixXd(const StateVector&)>& rest, StateVector start, int rounds);

/// Machines of a plant with effects, one per recording.
std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings);

/// The input of each joint as a machine feels it during one recording.
std::vector<Drive> drives_of(const Machine& machine, const Measured& data);

}  // namespace bayesctrl
