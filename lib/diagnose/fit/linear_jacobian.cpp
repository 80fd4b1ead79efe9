#include "diagnose/fit/linear_jacobian.hpp"

#include <algorithm>
#include <numeric>

#include "diagnose/settings.hpp"
#include "numerics/parallel.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// What unknowns do to accelerations and measured positions, per unit: one column for each, rows as the response takes
/// them.
struct Influence {
  std::vector<Eigen::MatrixXd> acceleration, measured;  // per recording; the latter of sensors alone, else empty
  Eigen::VectorXd rms;                                  // of accelerations
};

bool on_sensor(const Fit& fit, const Unknown& unknown) {
  return unknown.effect >= 0 && channel(fit.effects[static_cast<std::size_t>(unknown.effect)].form) == "sensor";
}

/// Of the unknowns in these `places`.
Influence influence(const FitProblem& problem, const Fit& fit, const std::vector<std::size_t>& places) {
  const auto count = static_cast<Eigen::Index>(places.size());
  const bool sensed = std::ranges::any_of(places, [&](std::size_t i) { return on_sensor(fit, fit.unknowns[i]); });
  Influence result{{}, {}, Eigen::VectorXd::Zero(count)};
  double samples = 0.0;
  for (std::size_t r = 0; r < problem.data.size(); ++r) {
    const Eigen::Index size = problem.data[r].position.size();
    Eigen::MatrixXd& acceleration = result.acceleration.emplace_back(size, count);
    if (sensed) result.measured.emplace_back(Eigen::MatrixXd::Zero(size, count));
    in_parallel(places.size(), [&](std::size_t place) {
      const auto i = static_cast<Eigen::Index>(place);
      const Unknown& unknown = fit.unknowns[places[place]];
      const double up = unknown.above(), down = unknown.below();
      Eigen::MatrixXd a;
      if (unknown.effect < 0) {
        Plant higher = fit.plant, lower = fit.plant;
        set_parameter(higher, unknown.name, up);
        set_parameter(lower, unknown.name, down);
        a = problem.forcing.acceleration(higher, r) - problem.forcing.acceleration(lower, r);
      } else {
        Effect higher = fit.effects[static_cast<std::size_t>(unknown.effect)], lower = higher;
        set_parameter(higher.form, unknown.name, up);
        set_parameter(lower.form, unknown.name, down);
        a = problem.forcing.acceleration(higher, r, fit.effects) - problem.forcing.acceleration(lower, r, fit.effects);
        if (on_sensor(fit, unknown)) {
          const Eigen::MatrixXd m = problem.forcing.measured(higher, r) - problem.forcing.measured(lower, r);
          result.measured[r].col(i) = m.transpose().reshaped() / (up - down);
        }
      }
      acceleration.col(i) = a.transpose().reshaped() / (up - down);
      result.rms[i] += acceleration.col(i).squaredNorm();
    });
    samples += static_cast<double>(problem.data[r].samples());
  }
  result.rms = (result.rms / samples).cwiseSqrt();
  return result;
}

}  // namespace

Eigen::MatrixXd linear_jacobian(const FitProblem& problem, const Fit& fit) {
  if (fit.unknowns.empty()) return Eigen::MatrixXd(problem.response.rows(), 0);
  std::vector<std::size_t> all(fit.unknowns.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  const Influence effect = influence(problem, fit, all);
  Eigen::MatrixXd jacobian = problem.response.responses(effect.acceleration);
  if (!effect.measured.empty()) jacobian += problem.response.measured(effect.measured);
  return jacobian;
}

void complete_priors(const FitProblem& problem, Fit& fit) {
  renew_priors(fit.unknowns, fit.effects);
  std::vector<std::size_t> open;
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    if (fit.unknowns[i].prior_deviation <= 0.0) open.push_back(i);
  }
  if (open.empty()) return;
  const double nominal = problem.forcing.nominal_acceleration();
  const Eigen::VectorXd rms = influence(problem, fit, open).rms;
  for (Eigen::Index i = 0; i < rms.size(); ++i) {
    Unknown& unknown = fit.unknowns[open[static_cast<std::size_t>(i)]];
    unknown.least_deviation = on_sensor(fit, unknown)
                                  ? kSettings.motion.prior_share
                                  : kSettings.motion.prior_share * nominal / std::max(rms[i], 1e-12 * nominal);
  }
  renew_priors(fit.unknowns, fit.effects);
}

}  // namespace bayesctrl
