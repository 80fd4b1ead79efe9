#include "numerics/minimize.hpp"

#include <cmath>
#include <limits>
#include <nlopt.hpp>
#include <stdexcept>

#include "numerics/detail/conjugate_gradients.hpp"

namespace bayesctrl {

namespace {

struct Call {
  const Objective* objective;
  Eigen::VectorXd x;
  Eigen::VectorXd gradient;
  MinimizeSummary* best;
  int max_evaluations;
};

double evaluate_call(unsigned size, const double* x, double* gradient, void* data) {
  auto& call = *static_cast<Call*>(data);
  if (call.best->evaluations >= call.max_evaluations) throw nlopt::forced_stop();  // NLopt's own limit lets one more by
  call.x = Eigen::Map<const Eigen::VectorXd>(x, size);
  double value = (*call.objective)(call.x, call.gradient);
  ++call.best->evaluations;
  if (!std::isfinite(value)) {  // the line search backs off from a large value, it cannot use NaN
    value = 1e300;
    call.gradient.setZero();
  }
  if (value < call.best->value) {
    call.best->value = value;
    call.best->x = call.x;
  }
  if (gradient != nullptr) Eigen::Map<Eigen::VectorXd>(gradient, size) = call.gradient;
  return value;
}

}  // namespace

MinimizeSummary minimize(const Objective& objective, const Eigen::VectorXd& start, const Eigen::VectorXd& low,
                         const Eigen::VectorXd& high, const MinimizeOptions& options) {
  const auto size = static_cast<unsigned>(start.size());
  if (low.size() != start.size() || high.size() != start.size() || (low.array() > high.array()).any()) {
    throw std::invalid_argument("bounds do not fit the starting point");
  }
  MinimizeSummary summary;
  summary.x = start.cwiseMax(low).cwiseMin(high);
  summary.value = std::numeric_limits<double>::infinity();
  if (options.method == MinimizeMethod::conjugate_gradients) {
    return conjugate_gradients(objective, summary.x, low, high, options);
  }
  Call call{&objective, summary.x, Eigen::VectorXd::Zero(size), &summary, options.max_evaluations};

  nlopt::opt optimizer(nlopt::LD_LBFGS, size);
  optimizer.set_lower_bounds(std::vector<double>(low.begin(), low.end()));
  optimizer.set_upper_bounds(std::vector<double>(high.begin(), high.end()));
  optimizer.set_min_objective(evaluate_call, &call);
  optimizer.set_ftol_rel(options.relative_tolerance);
  optimizer.set_maxeval(options.max_evaluations);
  std::vector<double> x(summary.x.begin(), summary.x.end());
  double value = 0.0;
  try {
    summary.converged = optimizer.optimize(x, value) != nlopt::MAXEVAL_REACHED;
  } catch (const std::runtime_error&) {
    summary.converged = false;  // NLopt's line search gave up; the best point so far stands
  }
  return summary;
}

}  // namespace bayesctrl
