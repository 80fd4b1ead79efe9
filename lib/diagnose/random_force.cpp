#include "diagnose/random_force.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr int kRounds = 3;      // of intensity and parameters
constexpr int kIterations = 8;  // of parameters
constexpr int kHalvings = 4;    // of a step that does not gain
constexpr double kGain = 0.01;  // nats, below which steps end

/// What the effects and the adjusted plant explain along the motion: rows of the response.
Eigen::VectorXd explained(const FitProblem& problem, const LinearResponse& response, const Fit& fit) {
  std::vector<Eigen::MatrixXd> acceleration, measured;
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    Eigen::MatrixXd a = problem.excitation.acceleration(fit.plant, r) + problem.excitation.acceleration(fit.effects, r);
    Eigen::MatrixXd m = Eigen::MatrixXd::Zero(a.rows(), a.cols());
    for (const Effect& effect : fit.effects) m += problem.excitation.measured(effect, r);
    acceleration.push_back(a.transpose().reshaped());
    measured.push_back(m.transpose().reshaped());
  }
  return response.responses(acceleration) + response.measured(measured);
}

Eigen::MatrixXd slopes(const FitProblem& problem, const LinearResponse& response, const Fit& fit) {
  Eigen::MatrixXd result(response.rows(), static_cast<Eigen::Index>(fit.unknowns.size()));
  for (Eigen::Index i = 0; i < result.cols(); ++i) {
    const Unknown& unknown = fit.unknowns[static_cast<std::size_t>(i)];
    Fit higher = fit, lower = fit;
    Unknown up = unknown, down = unknown;
    up.value = std::min(unknown.value + unknown.step, unknown.high);
    down.value = std::max(unknown.value - unknown.step, unknown.low);
    put(higher, up);
    put(lower, down);
    result.col(i) =
        (explained(problem, response, higher) - explained(problem, response, lower)) / (up.value - down.value);
  }
  return result;
}

/// Damped Gauss-Newton steps beside a random force whose response this is.
Fit descend(const FitProblem& problem, const LinearResponse& response, Fit fit) {
  const auto cost = [&](const Fit& f, const Eigen::VectorXd& rest) {
    return 0.5 * (rest.squaredNorm() + prior_cost(f));
  };
  Eigen::VectorXd rest = response.target() - explained(problem, response, fit);
  double reached = cost(fit, rest);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    const Eigen::MatrixXd columns = slopes(problem, response, fit);
    const Eigen::MatrixXd curvature = information(columns, fit);
    fit.covariance = curvature.ldlt().solve(Eigen::MatrixXd::Identity(curvature.rows(), curvature.cols()));
    Eigen::VectorXd step = step_within_bounds(curvature, columns.transpose() * rest - prior_slope(fit), fit.unknowns);
    double gained = 0.0;
    for (int halving = 0; halving < kHalvings && gained <= 0.0; ++halving, step *= 0.5) {
      Fit next = fit;
      assign(next, values_of(fit) + step);
      const Eigen::VectorXd left = response.target() - explained(problem, response, next);
      gained = reached - cost(next, left);
      if (gained <= 0.0) continue;
      next.covariance = fit.covariance;
      fit = std::move(next);
      rest = left;
      reached -= gained;
    }
    if (gained < kGain) break;
  }
  return fit;
}

}  // namespace

Fit beside_random_force(const FitProblem& problem, Fit fit) {
  if (fit.unknowns.empty()) return fit;
  for (int round = 0; round < kRounds; ++round) {
    const Eigen::VectorXd rest = problem.response.target() - explained(problem, problem.response, fit);
    fit = descend(problem, problem.response.beside_random(problem.response.likely_intensity(rest)), std::move(fit));
  }
  return fit;
}

}  // namespace bayesctrl
