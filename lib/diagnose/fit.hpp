#pragma once

#include <functional>

#include "diagnose/linear_response.hpp"
#include "diagnose/unknowns.hpp"
#include "physics/machine.hpp"

namespace bayesctrl {

/// State at the first sample of a window: [q, v] and, after a gap, the states of the joints' effects (presliding).
using WindowStart = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3 * kMaxJoints, 1>;

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
/// linear response and, where those mislead, from the machine itself. `effects` is the start. Throws NumericalError
/// when not even the start can be simulated.
Fit fit(const FitProblem& problem, std::vector<Effect> effects);

/// The same from where a fit is, with slopes from the machine itself.
Fit refined(const FitProblem& problem, Fit fit);

/// Simulated motion of a fit over its windows, elsewhere what `elsewhere` says.
std::vector<Trajectory> simulated(const FitProblem& problem, const Fit& fit, const std::vector<Trajectory>& elsewhere);

/// Levenberg-Marquardt: the start from `start` on that makes `rest` (samples x joints) smallest. One whose simulation
/// diverges throws NumericalError.
WindowStart fit_start(const std::function<Eigen::MatrixXd(const WindowStart&)>& rest, WindowStart start, int rounds);

/// A first guess from a known motion. With `hidden` effects have states of their own.
WindowStart first_start(const Segment& window, const Trajectory& path, bool hidden);

/// Machines of a plant with effects, one per recording.
std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings);

/// The input of each joint as a machine feels it during one recording.
std::vector<Drive> drives_of(const Machine& machine, const Measured& data);

}  // namespace bayesctrl
