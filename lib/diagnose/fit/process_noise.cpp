#include "diagnose/fit/process_noise.hpp"

#include <utility>

#include "diagnose/fit/linear_jacobian.hpp"

namespace bayesctrl {

namespace {

constexpr int kIntensityRounds = 3;  // of intensity and parameters
constexpr int kIterations = 8;       // of parameters
constexpr int kHalvings = 4;         // of a step that does not gain
constexpr double kLeastGain = 0.01;  // nats, below which steps end

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

/// Damped Gauss-Newton steps for rows that are whitened already.
Fit descend(const FitProblem& problem, Fit fit) {
  const auto cost = [](const Fit& f) { return 0.5 * (f.sse + prior_cost(f)); };
  const auto look = [&](Fit& f) {
    f.residual = problem.response.target() - explained(problem, f);
    f.sse = f.residual.squaredNorm();
  };
  look(fit);
  Eigen::MatrixXd jacobian;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    jacobian = linear_jacobian(problem, fit);
    Eigen::VectorXd step = step_within_bounds(information(jacobian, fit),
                                              jacobian.transpose() * fit.residual - prior_gradient(fit), fit.unknowns);
    double gained = 0.0;
    for (int halving = 0; halving < kHalvings && gained <= 0.0; ++halving, step *= 0.5) {
      Fit next = fit;
      assign(next, values_of(fit) + step);
      look(next);
      gained = cost(fit) - cost(next);
      if (gained > 0.0) fit = std::move(next);
    }
    if (gained < kLeastGain) break;
  }
  weigh(problem, fit, jacobian);
  return fit;
}

}  // namespace

Fit fit_with_process_noise(const FitProblem& problem, const LinearResponse& white, Fit fit) {
  const FitProblem whitened{problem.nominal, problem.given,   problem.free,    problem.data,
                            white,           problem.forcing, problem.penalty, problem.max_step};
  return descend(whitened, std::move(fit));
}

Eigen::VectorXd likely_intensity(const FitProblem& problem, Fit fit) {
  Eigen::VectorXd intensity;
  for (int round = 0; round < kIntensityRounds; ++round) {
    intensity = problem.response.likely_intensity(problem.response.target() - explained(problem, fit));
    if (round + 1 == kIntensityRounds) break;
    fit = fit_with_process_noise(problem, problem.response.with_process_noise(intensity), std::move(fit));
  }
  return intensity;
}

}  // namespace bayesctrl
