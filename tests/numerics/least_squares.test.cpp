#include "numerics/least_squares.hpp"

#include <catch2/catch.hpp>
#include <optional>

#include "base/random.hpp"
#include "numerics/nist_problems.hpp"
#include "support/dense.hpp"

using namespace bayesctrl;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

VectorXd vector_of(const std::vector<double>& list) {
  return Eigen::Map<const VectorXd>(list.data(), static_cast<Eigen::Index>(list.size()));
}

/// Regression of data: a Jacobian by central differences; `defined_below`: no cost where the first parameter is larger.
struct Regression {
  const nist::Problem& data;
  double defined_below = 1e300;
  VectorXd low{}, high{};  // of parameters
  int jacobians = 0;

  VectorXd residual(const VectorXd& b) const {
    VectorXd r(data.x.size());
    for (std::size_t i = 0; i < data.x.size(); ++i) {
      r[static_cast<Eigen::Index>(i)] = data.y[i] - data.model(data.x[i], b);
    }
    return r;
  }
  double cost(const VectorXd& b) const { return 0.5 * residual(b).squaredNorm(); }
  QuadraticModel model(const VectorXd& b, double /*agreement*/) {
    ++jacobians;
    MatrixXd jacobian(data.x.size(), b.size());
    for (Eigen::Index i = 0; i < b.size(); ++i) {
      VectorXd up = b, down = b;
      const double h = 1e-6 * std::max(std::abs(b[i]), 1e-6);
      up[i] += h;
      down[i] -= h;
      jacobian.col(i) = (residual(down) - residual(up)) / (2.0 * h);
    }
    QuadraticModel model{jacobian.transpose() * jacobian, jacobian.transpose() * residual(b), {}, {}};
    if (low.size() > 0) {
      model.low = low - b;
      model.high = high - b;
    }
    return model;
  }
  VectorXd moved(const VectorXd& b, const VectorXd& step) const {
    const VectorXd next = b + step;
    if (next[0] > defined_below) throw NumericalError("not defined");
    return next;
  }
};

const LeastSquaresOptions kToTheEnd{.max_iterations = 200, .max_trials = 20, .least_relative_gain = 1e-12};

}  // namespace

TEST_CASE("Certified parameters of NIST's regression problems are found from all their starts", "[numerics]") {
  for (const nist::Problem& problem : nist::problems()) {
    for (const std::vector<double>& start : problem.starts) {
      Regression regression{problem};
      VectorXd b = vector_of(start);
      const LeastSquaresSummary summary = least_squares(regression, b, kToTheEnd);
      CAPTURE(problem.name, start.front(), summary.iterations, summary.evaluations, b.transpose());
      CHECK(2.0 * summary.cost == Approx(problem.sse).epsilon(1e-8));
      // Where the cost is flat to 1e-12 its argument is known to about the root of that.
      CHECK(((b - vector_of(problem.certified)).array() / b.array()).abs().maxCoeff() < 1e-5);
      CHECK((summary.end == LeastSquaresEnd::converged || summary.end == LeastSquaresEnd::no_descent));
      CHECK(summary.iterations == regression.jacobians);
    }
  }
}

TEST_CASE("A linear problem takes one step, and a Gauss-Newton step ends where the normal equations do", "[numerics]") {
  const MatrixXd jacobian = (MatrixXd(4, 2) << 1, 0, 1, 1, 1, 2, 1, 3).finished();
  const VectorXd target = (VectorXd(4) << 1, 3, 2, 5).finished();
  const QuadraticModel model{jacobian.transpose() * jacobian, jacobian.transpose() * target, {}, {}};
  const VectorXd step = bounded_step(model);
  CHECK(step.isApprox(testing::dense::solve(model.hessian, model.descent), 1e-12));
  CHECK(promised_gain(model, step) ==
        Approx(0.5 * (target.squaredNorm() - (target - jacobian * step).squaredNorm())).epsilon(1e-12));
}

TEST_CASE("Within bounds a step is that of the best set of active bounds", "[numerics]") {
  // All 3^3 ways to hold numbers at bounds, by hand.
  const MatrixXd hessian = (MatrixXd(3, 3) << 4, 1, 0.5, 1, 3, -0.8, 0.5, -0.8, 2).finished();
  const VectorXd low = VectorXd::Constant(3, -0.4), high = VectorXd::Constant(3, 0.6);
  for (const double scale : {0.1, 1.0, 5.0}) {
    const VectorXd descent = scale * (VectorXd(3) << 1.0, -2.0, 1.5).finished();
    const QuadraticModel model{hessian, descent, low, high};
    double most = -1e300;
    for (int code = 0; code < 27; ++code) {
      VectorXd step = VectorXd::Zero(3);
      std::vector<Eigen::Index> free;
      for (int i = 0, rest = code; i < 3; ++i, rest /= 3) {
        if (rest % 3 == 0) free.push_back(i);
        if (rest % 3 == 1) step[i] = low[i];
        if (rest % 3 == 2) step[i] = high[i];
      }
      if (!free.empty()) {
        const VectorXd left = descent - hessian * step;
        step(free) = testing::dense::solve(hessian(free, free), left(free)).col(0);
      }
      if ((step - low).minCoeff() < 0.0 || (high - step).minCoeff() < 0.0) continue;
      most = std::max(most, promised_gain(model, step));
    }
    const VectorXd step = bounded_step(model);
    CAPTURE(scale, step.transpose());
    CHECK((step - low).minCoeff() >= 0.0);
    CHECK((high - step).minCoeff() >= 0.0);
    CHECK(promised_gain(model, step) == Approx(most).epsilon(1e-9));
  }
}

TEST_CASE("What has not stopped at a bound has no gradient left", "[numerics]") {
  RandomStream random(5);
  for (int trial = 0; trial < 200; ++trial) {
    constexpr Eigen::Index kCount = 4;
    MatrixXd root(kCount, kCount);
    QuadraticModel model{{}, VectorXd(kCount), VectorXd(kCount), VectorXd(kCount)};
    for (double& x : root.reshaped()) x = draw_normal(random);
    for (double& x : model.descent) x = 3.0 * draw_normal(random);
    model.hessian = root * root.transpose() + 0.1 * MatrixXd::Identity(kCount, kCount);
    for (Eigen::Index i = 0; i < kCount; ++i) {
      const double value = draw_uniform(random, -0.5, 0.5);
      model.low[i] = -1.0 - value;
      model.high[i] = i == 0 ? 1e300 : 1.0 - value;
    }
    const VectorXd step = bounded_step(model), gradient = model.hessian * step - model.descent;
    for (Eigen::Index i = 0; i < kCount; ++i) {
      CHECK(step[i] >= model.low[i]);
      CHECK(step[i] <= model.high[i]);
      if (step[i] > model.low[i] && step[i] < model.high[i]) {
        CHECK(std::abs(gradient[i]) < 1e-9 * (1.0 + model.descent.norm()));
      }
    }
  }
}

TEST_CASE("A number that nothing depends on stays, and units of parameters change no step", "[numerics]") {
  MatrixXd hessian = MatrixXd::Zero(3, 3);
  hessian.topLeftCorner(2, 2) << 2.0, 1.0, 1.0, 3.0;
  const VectorXd descent = (VectorXd(3) << 1.0, -1.0, 0.0).finished();
  const VectorXd step = bounded_step({hessian, descent, {}, {}});
  CHECK(step[2] == 0.0);
  const VectorXd unit = (VectorXd(3) << 1e-6, 1e8, 1.0).finished();
  const VectorXd rescaled =
      bounded_step({unit.asDiagonal() * hessian * unit.asDiagonal(), unit.cwiseProduct(descent), {}, {}});
  CHECK(unit.cwiseProduct(rescaled).isApprox(step, 1e-10));
}

TEST_CASE("What ends an iteration is said", "[numerics]") {
  const nist::Problem problem = nist::problems().front();
  Regression regression{problem};
  VectorXd b = vector_of(problem.starts[1]);
  CHECK(least_squares(regression, b, {.max_iterations = 1}).end == LeastSquaresEnd::iterations);
  CHECK(least_squares(regression, b, kToTheEnd).end == LeastSquaresEnd::converged);
  const VectorXd found = b;
  CHECK(least_squares(regression, b, {.least_promise = 1e-6}).evaluations == 0);  // nothing to gain: nothing tried
  CHECK(b == found);

  Regression nowhere{problem, -1e300};
  b = vector_of(problem.starts[1]);
  const LeastSquaresSummary stuck = least_squares(nowhere, b, kToTheEnd);
  CHECK(stuck.end == LeastSquaresEnd::no_descent);
  CHECK(b == vector_of(problem.starts[1]));
  CHECK(stuck.cost == nowhere.cost(b));

  struct Undefined : Regression {
    QuadraticModel model(const VectorXd&, double) { throw NumericalError("next to here it diverges"); }
  } undefined{{problem}};
  CHECK(least_squares(undefined, b, kToTheEnd).end == LeastSquaresEnd::undefined);

  struct Overflowing : Regression {  // no step is made of what is no number
    QuadraticModel model(const VectorXd& at, double agreement) {
      QuadraticModel result = Regression::model(at, agreement);
      result.hessian(0, 0) = std::numeric_limits<double>::infinity();
      return result;
    }
    VectorXd moved(const VectorXd& at, const VectorXd& step) {
      CHECK(step.allFinite());
      return Regression::moved(at, step);
    }
  } overflowing{{problem}};
  CHECK(least_squares(overflowing, b, kToTheEnd).end == LeastSquaresEnd::undefined);
  CHECK(b == vector_of(problem.starts[1]));
}

TEST_CASE("Where the cost is not defined, steps are shortened until it is; bounds hold on the way", "[numerics]") {
  const nist::Problem problem = nist::problems().front();
  Regression regression{problem, 239.5};
  VectorXd b = vector_of(problem.starts[1]);
  b[0] = 150.0;
  least_squares(regression, b, kToTheEnd);
  CHECK(b[0] == Approx(problem.certified[0]).epsilon(1e-5));

  Regression bounded{problem, 1e300, (VectorXd(2) << 0.0, 0.0).finished(), (VectorXd(2) << 200.0, 1.0).finished()};
  b = vector_of(problem.starts[1]);
  b[0] = 150.0;
  least_squares(bounded, b, kToTheEnd);
  CHECK(b[0] == Approx(200.0).epsilon(1e-12));
  double best = 1e300;  // along the edge
  for (double rate = 6e-4; rate < 8e-4; rate += 1e-7) {
    best = std::min(best, bounded.cost((VectorXd(2) << 200.0, rate).finished()));
  }
  CHECK(bounded.cost(b) <= best * (1.0 + 1e-6));
}

TEST_CASE("A Jacobian that is kept while it holds leads to the same minimum with fewer of them", "[numerics]") {
  for (const nist::Problem& problem : nist::problems()) {
    struct Keeping : Regression {
      QuadraticModel model(const VectorXd& b, double agreement) {
        if (last && agreement < 0.05) {
          QuadraticModel model{last->transpose() * *last, last->transpose() * residual(b), {}, {}};
          model.kept = true;
          return model;
        }
        ++jacobians;
        last = MatrixXd(data.x.size(), b.size());
        for (Eigen::Index i = 0; i < b.size(); ++i) {
          VectorXd up = b;
          const double h = 1e-6 * std::max(std::abs(b[i]), 1e-6);
          up[i] += h;
          last->col(i) = (residual(b) - residual(up)) / h;
        }
        return {last->transpose() * *last, last->transpose() * residual(b), {}, {}};
      }
      std::optional<MatrixXd> last{};
    } keeping{{problem}};
    VectorXd b = vector_of(problem.starts.back());
    const LeastSquaresSummary summary = least_squares(keeping, b, kToTheEnd);
    CAPTURE(problem.name, summary.iterations, keeping.jacobians);
    CHECK(2.0 * summary.cost == Approx(problem.sse).epsilon(1e-6));
    CHECK(keeping.jacobians <= summary.iterations);
  }
}
