#include "numerics/least_squares.hpp"

#include <vector>

#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

/// H x = g for some of the unknowns, scaled so that the diagonal is 1.
Eigen::VectorXd solve(const Eigen::MatrixXd& hessian, const Eigen::VectorXd& descent,
                      const std::vector<Eigen::Index>& of) {
  const Eigen::VectorXd scale = hessian.diagonal()(of).array().max(1e-300).rsqrt();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * hessian(of, of) * scale.asDiagonal();
  const Eigen::VectorXd target = scale.cwiseProduct(descent(of));
  return scale.cwiseProduct(solve_symmetric(scaled, target).col(0));
}

}  // namespace

Eigen::VectorXd bounded_step(const QuadraticModel& model, double damping) {
  const Eigen::Index count = model.descent.size();
  Eigen::MatrixXd hessian = model.hessian;
  hessian.diagonal() *= 1.0 + damping;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(count);
  std::vector<Eigen::Index> inside;
  for (Eigen::Index i = 0; i < count; ++i) {
    if (hessian(i, i) > 0.0) inside.push_back(i);
  }
  while (!inside.empty()) {
    const Eigen::VectorXd left = model.descent - hessian * step;  // by those that have stopped
    const Eigen::VectorXd move = solve(hessian, left, inside);
    if (model.low.size() == 0) {
      step(inside) = move;
      break;
    }
    std::vector<Eigen::Index> go_on;
    for (std::size_t k = 0; k < inside.size(); ++k) {
      const Eigen::Index i = inside[k];
      const double to = move[static_cast<Eigen::Index>(k)];
      if (to >= model.low[i] && to <= model.high[i]) {
        go_on.push_back(i);
      } else {
        step[i] = std::clamp(to, model.low[i], model.high[i]);
      }
    }
    if (go_on.size() == inside.size()) {
      step(inside) = move;
      break;
    }
    inside = std::move(go_on);
  }
  return step;
}

double promised_gain(const QuadraticModel& model, const Eigen::VectorXd& step) {
  return step.dot(model.descent) - 0.5 * step.dot(model.hessian * step);
}

}  // namespace bayesctrl
