#include "diagnose/fit/process_noise.hpp"

#include <utility>

#include "diagnose/fit/linear_jacobian.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// What the effects and the adjusted plant explain along the motion: rows of the response.
Eigen::VectorXd explained(const FitProblem& problem, const Fit& fit) {
  std::vector<Eigen::MatrixXd> acceleration, measured;
  bool on_sensor = false;
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    Eigen::MatrixXd a = problem.forcing.acceleration(fit.plant, r) + problem.forcing.acceleration(fit.effects, r);
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(a.rows(), a.cols());
    for (const Effect& effect : fit.effects) {
      if (channel(effect.form) != "sensor") continue;
      on_sensor = true;
      m += problem.forcing.measured(effect, r);
    }
    acceleration.push_back(a.transpose().reshaped());
    measured.push_back(m.transpose().reshaped());
  }
  Eigen::VectorXd rows = problem.response.responses(acceleration);
  if (on_sensor) rows += problem.response.measured(measured);
  return rows;
}

/// A fit's parameters for rows that are whitened: nothing is simulated, what the model explains is linear in time.
class WhitenedFit {
 public:
  explicit WhitenedFit(const FitProblem& problem) : problem_(problem) {}

  double cost(const Fit& fit) const { return 0.5 * (fit.sse + prior_cost(fit)); }

  QuadraticModel model(const Fit& fit, double /*agreement*/) {
    jacobian_ = linear_jacobian(problem_, fit);
    return quadratic_model(jacobian_, fit);
  }

  Fit moved(const Fit& fit, const Eigen::VectorXd& step) const {
    Fit next = fit;
    assign(next, values_of(fit) + step);
    return evaluated(std::move(next));
  }

  Fit evaluated(Fit fit) const {
    fit.residual = problem_.response.target() - explained(problem_, fit);
    fit.sse = fit.residual.squaredNorm();
    return fit;
  }

  const Eigen::MatrixXd& jacobian() const { return jacobian_; }

 private:
  const FitProblem& problem_;
  Eigen::MatrixXd jacobian_;
};

}  // namespace

FitProblem beside(const FitProblem& problem, const LinearResponse& white) {
  return {problem.nominal, problem.given,   problem.free,    problem.data,
          white,           problem.forcing, problem.penalty, problem.max_step};
}

Fit fit_with_process_noise(const FitProblem& problem, const LinearResponse& white, Fit fit) {
  const FitProblem whitened = beside(problem, white);
  renew_priors(fit.unknowns, fit.effects);
  WhitenedFit descent(whitened);
  fit = descent.evaluated(std::move(fit));
  least_squares(descent, fit,
                {.max_iterations = kSettings.fit.whitened_iterations,
                 .max_trials = kSettings.fit.whitened_trials,
                 .least_gain = kSettings.fit.whitened_gain});
  weigh(whitened, fit, descent.jacobian());
  fit.log_evidence -= white.log_scale().sum();
  return fit;
}

Eigen::VectorXd likely_intensity(const FitProblem& problem, Fit fit) {
  Eigen::VectorXd intensity;
  for (int round = 0; round < kSettings.fit.intensity_rounds; ++round) {
    intensity = problem.response.likely_intensity(problem.response.target() - explained(problem, fit));
    if (round + 1 == kSettings.fit.intensity_rounds) break;
    fit = fit_with_process_noise(problem, problem.response.with_process_noise(intensity), std::move(fit));
  }
  return intensity;
}

BesideNoise beside_likely_noise(const FitProblem& problem, const Fit& fit) {
  LinearResponse white = problem.response.with_process_noise(likely_intensity(problem, fit));
  Fit settled = fit_with_process_noise(problem, white, fit);
  return {std::move(white), std::move(settled)};
}

}  // namespace bayesctrl
