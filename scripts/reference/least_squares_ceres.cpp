// Yardstick of lib/numerics/least_squares: the same problems by Ceres (http://ceres-solver.org), with the same Jacobians.
//
//   apt-get install libceres-dev
//   g++ -O2 -std=c++20 -Ilib -Itests -isystem /usr/include/eigen3 scripts/reference/least_squares_ceres.cpp \
//       lib/numerics/least_squares.cpp lib/base/error.cpp -lceres -lglog -o /tmp/least_squares_ceres
//   /tmp/least_squares_ceres
//
// Prints, per problem and start, the sum of squared errors, Jacobians, evaluations of the residual and time of both.

#include <ceres/ceres.h>

#include <chrono>
#include <cstdio>

#include "numerics/least_squares.hpp"
#include "numerics/nist_problems.hpp"

namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

VectorXd residual(const nist::Problem& problem, const VectorXd& b) {
  VectorXd r(problem.x.size());
  for (std::size_t i = 0; i < problem.x.size(); ++i) r[i] = problem.y[i] - problem.model(problem.x[i], b);
  return r;
}

/// Of the model by its parameters, central differences.
MatrixXd jacobian(const nist::Problem& problem, const VectorXd& b) {
  MatrixXd result(problem.x.size(), b.size());
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    VectorXd up = b, down = b;
    const double h = 1e-6 * std::max(std::abs(b[i]), 1e-6);
    up[i] += h;
    down[i] -= h;
    result.col(i) = (residual(problem, down) - residual(problem, up)) / (2.0 * h);
  }
  return result;
}

struct Count {
  double sse = 0.0;
  int jacobians = 0, evaluations = 0;
  double seconds = 0.0;
};

struct CeresCost : ceres::CostFunction {
  CeresCost(const nist::Problem& of, Count& in, int parameters) : problem(of), count(in) {
    set_num_residuals(static_cast<int>(problem.x.size()));
    mutable_parameter_block_sizes()->push_back(parameters);
  }
  bool Evaluate(double const* const* x, double* r, double** j) const override {
    const int size = parameter_block_sizes()[0];
    const VectorXd b = Eigen::Map<const VectorXd>(x[0], size);
    const VectorXd here = residual(problem, b);
    ++count.evaluations;
    if (!here.allFinite()) return false;
    Eigen::Map<VectorXd>(r, here.size()) = here;
    if (j != nullptr && j[0] != nullptr) {
      ++count.jacobians;
      Eigen::Map<Eigen::Matrix<double, -1, -1, Eigen::RowMajor>>(j[0], here.size(), size) = -jacobian(problem, b);
    }
    return true;
  }
  const nist::Problem& problem;
  Count& count;
};

struct OwnCost {
  double cost(const VectorXd& b) const { return 0.5 * residual(problem, b).squaredNorm(); }
  bayesctrl::QuadraticModel model(const VectorXd& b, double) const {
    const MatrixXd j = jacobian(problem, b);
    return {j.transpose() * j, j.transpose() * residual(problem, b), {}, {}};
  }
  VectorXd moved(const VectorXd& b, const VectorXd& step) const { return b + step; }
  const nist::Problem& problem;
};

Count by_ceres(const nist::Problem& problem, VectorXd b) {
  Count count;
  ceres::Problem solved;
  solved.AddResidualBlock(new CeresCost(problem, count, static_cast<int>(b.size())), nullptr, b.data());
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-14;
  options.gradient_tolerance = 1e-16;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &solved, &summary);
  count.sse = 2.0 * summary.final_cost;
  return count;
}

Count by_own(const nist::Problem& problem, VectorXd b) {
  OwnCost cost{problem};
  const bayesctrl::LeastSquaresSummary summary =
      bayesctrl::least_squares(cost, b, {.max_iterations = 200, .max_trials = 20, .least_relative_gain = 1e-12});
  return {2.0 * summary.cost, summary.iterations, summary.evaluations, 0.0};
}

Count timed(Count (*solve)(const nist::Problem&, VectorXd), const nist::Problem& problem, const VectorXd& start) {
  const auto begun = std::chrono::steady_clock::now();
  Count count = solve(problem, start);
  count.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return count;
}

}  // namespace

int main() {
  std::printf("%-8s %8s  %-6s %15s %9s %11s %8s\n", "problem", "start", "solver", "sse", "jacobians", "evaluations",
              "time/us");
  for (const nist::Problem& problem : nist::problems()) {
    for (const std::vector<double>& start : problem.starts) {
      const VectorXd b = Eigen::Map<const VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
      for (const auto& [name, solve] : {std::pair("ceres", &by_ceres), std::pair("own", &by_own)}) {
        const Count count = timed(solve, problem, b);
        std::printf("%-8s %8g  %-6s %15.9g %9d %11d %8.0f\n", problem.name.c_str(), start.front(), name, count.sse,
                    count.jacobians, count.evaluations, 1e6 * count.seconds);
      }
    }
  }
}
