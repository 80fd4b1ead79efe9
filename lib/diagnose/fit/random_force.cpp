#include "diagnose/fit/random_force.hpp"

#include <utility>

#include "diagnose/fit/linear_slopes.hpp"

namespace bayesctrl {

namespace {

constexpr int kForceRounds = 3;      // of intensity and parameters
constexpr int kIterations = 8;       // of parameters
constexpr int kHalvings = 4;         // of a step that does not gain
constexpr double kForceGain = 0.01;  // nats, below which steps end

/// What the effects and the adjusted plant explain along the motion: rows of the response.
Eigen::VectorXd explained(const FitProblem& problem, const Fit& fit) {
  std::vector<Eigen::MatrixXd> acceleration, measured;
  bool on_sensor = false;
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    Eigen::MatrixXd a = problem.excitation.acceleration(fit.plant, r) + problem.excitation.acceleration(fit.effects, r);
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(a.rows(), a.cols());
    for (const Effect& effect : fit.effects) {
      if (channel(effect.form) != "sensor") continue;
      on_sensor = true;
      m += problem.excitation.measured(effect, r);
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
  const auto cost = [](const Fit& f) { return 0.5 * (f.squares + prior_cost(f)); };
  const auto look = [&](Fit& f) {
    f.residual = problem.response.target() - explained(problem, f);
    f.squares = f.residual.squaredNorm();
  };
  look(fit);
  Eigen::MatrixXd slopes;
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    slopes = linear_slopes(problem, fit);
    Eigen::VectorXd step = step_within_bounds(information(slopes, fit),
                                              slopes.transpose() * fit.residual - prior_slope(fit), fit.unknowns);
    double gained = 0.0;
    for (int halving = 0; halving < kHalvings && gained <= 0.0; ++halving, step *= 0.5) {
      Fit next = fit;
      assign(next, values_of(fit) + step);
      look(next);
      gained = cost(fit) - cost(next);
      if (gained > 0.0) fit = std::move(next);
    }
    if (gained < kForceGain) break;
  }
  weigh(problem, fit, slopes);
  return fit;
}

}  // namespace

Fit beside_random_force(const FitProblem& problem, const LinearResponse& white, Fit fit) {
  const FitProblem whitened{problem.nominal, problem.given,      problem.free,    problem.data,
                            white,           problem.excitation, problem.penalty, problem.max_step};
  return descend(whitened, std::move(fit));
}

Eigen::VectorXd likely_intensity(const FitProblem& problem, Fit fit) {
  Eigen::VectorXd intensity;
  for (int round = 0; round < kForceRounds; ++round) {
    intensity = problem.response.likely_intensity(problem.response.target() - explained(problem, fit));
    if (round + 1 == kForceRounds) break;
    fit = beside_random_force(problem, problem.response.beside_random(intensity), std::move(fit));
  }
  return intensity;
}

}  // namespace bayesctrl
