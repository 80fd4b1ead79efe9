#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <string_view>

namespace bayesctrl {

/// f(x), and its gradient written to `gradient` (same size as x). May return NaN or +inf where f is not defined.
using Objective = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd& gradient)>;

/// How the next point is found: limited-memory BFGS (NLopt), or conjugate gradients (Polak & Ribiere) with a line
/// search after that of Rasmussen's GPML toolbox, cubic and quadratic steps within the Wolfe-Powell conditions.
enum class MinimizeMethod { lbfgs, conjugate_gradients };
constexpr std::array<std::string_view, 2> names(MinimizeMethod) { return {"lbfgs", "conjugate_gradients"}; }

struct MinimizeOptions {
  MinimizeMethod method = MinimizeMethod::lbfgs;
  int max_evaluations = 200;
  double relative_tolerance = 1e-9;  // of the objective, between accepted steps
};

struct MinimizeSummary {
  Eigen::VectorXd x;  // the best point that was evaluated
  double value = 0.0;
  int evaluations = 0;
  bool converged = false;  // false: stopped by max_evaluations or by a failing line search
};

/// Minimum within box bounds, from `start` (moved into the bounds).
MinimizeSummary minimize(const Objective& objective, const Eigen::VectorXd& start, const Eigen::VectorXd& low,
                         const Eigen::VectorXd& high, const MinimizeOptions& options = {});

}  // namespace bayesctrl
