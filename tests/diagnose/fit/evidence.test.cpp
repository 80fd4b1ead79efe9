// What a fit says of a linear machine is in closed form: parameters, deviations, evidence; how fine it integrates.

#include <catch2/catch.hpp>

#include "diagnose/fit/fit.hpp"
#include "diagnose/fit/linear_jacobian.hpp"
#include "physics/catalogue.hpp"
#include "support/compare.hpp"
#include "support/dense.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::largest_difference, testing::Linearised, testing::recorded;

namespace {

constexpr double kSlideNoise = 5e-3;
const Plant kDriven = Mass{1.5, 0.9};
const std::vector<Effect> kLinear{{ConstantBias{0.3}, 0, -1}, {InputGain{1.1}, 0, -1}};

/// A slide with effects in which it is linear, and the truth.
Linearised driven(std::uint64_t seed) {
  const Machine machine(kDriven, kLinear);
  return {kDriven,
          {recorded(machine, {.seconds = 4.0, .noise = kSlideNoise, .seed = seed}),
           recorded(machine, {.seconds = 4.0, .noise = kSlideNoise, .phase = 2.0, .seed = seed + 1})},
          kSlideNoise};
}

/// Normal rows y = X b + white noise, b about m with deviations s: log density of y without its constant, and the most
/// probable b.
struct Regression {
  Eigen::MatrixXd x;
  Eigen::VectorXd y, m, s;

  double log_evidence() const {
    const Eigen::MatrixXd scaled = x * s.asDiagonal();
    const Eigen::MatrixXd covariance = Eigen::MatrixXd::Identity(y.size(), y.size()) + scaled * scaled.transpose();
    return testing::dense::log_density(y - x * m, covariance);
  }
  Eigen::MatrixXd covariance() const {
    const Eigen::MatrixXd precision = s.cwiseAbs2().cwiseInverse().asDiagonal();
    return testing::dense::inverse(x.transpose() * x + precision);
  }
  Eigen::VectorXd best() const { return m + covariance() * (x.transpose() * (y - x * m)); }
};

/// A fit that holds such a regression at b.
Fit as_fit(const Regression& regression, const Eigen::VectorXd& b) {
  Fit fit;
  for (Eigen::Index i = 0; i < b.size(); ++i) {
    fit.unknowns.push_back({-1, "", b[i], -kInfinity, kInfinity, regression.m[i], regression.s[i]});
  }
  fit.residual = regression.y - regression.x * b;
  fit.sse = fit.residual.squaredNorm();
  return fit;
}

Regression drawn_regression(std::uint64_t seed, Eigen::Index columns) {
  RandomStream random(seed);
  const auto normal = [&](Eigen::Index rows, Eigen::Index cols) {
    Eigen::MatrixXd matrix(rows, cols);
    for (double& value : matrix.reshaped()) value = draw_normal(random);
    return matrix;
  };
  Regression regression{normal(30, columns), normal(30, 1), normal(columns, 1), normal(columns, 1).cwiseAbs()};
  regression.s.array() += 0.05;
  regression.y += regression.x * regression.m;
  return regression;
}

}  // namespace

TEST_CASE("The evidence of a linear model is the density of its rows, less the penalty of its effects",
          "[diagnose][fit]") {
  const Linearised about = driven(1);
  for (const Eigen::Index columns : {0, 1, 3, 6}) {
    const Regression regression = drawn_regression(static_cast<std::uint64_t>(columns) + 3, columns);
    Fit fit = as_fit(regression, regression.best());
    fit.effects = kLinear;
    weigh(about.problem, fit, regression.x);
    CAPTURE(columns);
    CHECK(fit.log_evidence == Approx(regression.log_evidence() - 2.0 * about.problem.penalty));
    CHECK(largest_difference(fit.covariance, regression.covariance()) < 1e-9);
    for (Eigen::Index i = 0; i < columns; ++i) fit.unknowns[static_cast<std::size_t>(i)].name = std::to_string(i);
    if (columns < 3) continue;
    CHECK(fit.deviation(-1, "2") == Approx(std::sqrt(regression.covariance()(2, 2))));
    CHECK(fit.deviation(0, "2") == 0.0);
    CHECK(fit.deviation(-1, "none") == 0.0);
  }
}

TEST_CASE("The quadratic model of a fit has the slope and the curvature of its cost, and bounds about where it is",
          "[diagnose][fit]") {
  const Regression regression = drawn_regression(8, 3);
  const Eigen::VectorXd here = Eigen::Vector3d(0.4, -0.7, 0.1);
  const auto cost = [&](const Eigen::VectorXd& b) {
    const Fit fit = as_fit(regression, b);
    return 0.5 * (fit.sse + prior_cost(fit));
  };
  Fit fit = as_fit(regression, here);
  fit.unknowns[1].low = -1.0;
  fit.unknowns[1].high = 2.0;
  const QuadraticModel model = quadratic_model(regression.x, fit);
  for (Eigen::Index i = 0; i < 3; ++i) {
    const Eigen::VectorXd step = 1e-3 * Eigen::VectorXd::Unit(3, i);
    CHECK(-model.descent[i] == Approx((cost(here + step) - cost(here - step)) / 2e-3).epsilon(1e-6));
    const Eigen::VectorXd other = Eigen::Vector3d(0.3, 0.5, -0.2);
    const double rise = cost(here + other) - cost(here) + model.descent.dot(other);
    CHECK(0.5 * other.dot(model.hessian * other) == Approx(rise).epsilon(1e-9));
  }
  CHECK(model.low[1] == Approx(-0.3));
  CHECK(model.high[1] == Approx(2.7));
  CHECK(model.low[0] == -kInfinity);
}

TEST_CASE("On a linear machine a fit is the regression of its rows, wherever it starts, with priors settled before",
          "[diagnose][fit]") {
  const Linearised about = driven(1);
  Fit at_start = about.at_truth(kLinear);
  complete_priors(about.problem, at_start);
  Regression regression{linear_jacobian(about.problem, at_start), about.response.target(), {}, {}};
  regression.m = Eigen::Vector2d(0.0, 1.0);
  regression.s = Eigen::Vector2d(at_start.unknowns[0].prior_deviation, at_start.unknowns[1].prior_deviation);
  regression.y += regression.x * Eigen::Vector2d(0.0, 1.0);  // the nominal has a gain of 1
  const Eigen::VectorXd best = regression.best();
  for (const auto& [bias, gain] : {std::pair{0.0, 1.0}, {3.0, 0.5}, {-2.0, 2.0}}) {
    const Fit found = fit(about.problem, {{ConstantBias{bias}, 0, -1}, {InputGain{gain}, 0, -1}});
    CAPTURE(bias, gain, found.sse);
    REQUIRE(found.unknowns.size() == 2);
    for (Eigen::Index i = 0; i < 2; ++i) {
      const Unknown& unknown = found.unknowns[static_cast<std::size_t>(i)];
      CHECK(unknown.prior_deviation == Approx(regression.s[i]).epsilon(1e-6));
      CHECK(std::abs(unknown.value - best[i]) < 0.02 * std::sqrt(regression.covariance()(i, i)));
      CHECK(found.deviation(static_cast<int>(i), unknown.name) ==
            Approx(std::sqrt(regression.covariance()(i, i))).epsilon(1e-3));
    }
    CHECK(std::abs(found.log_evidence + 2.0 * about.problem.penalty - regression.log_evidence()) < 0.05);
  }
}

TEST_CASE("Deviations of a fit are those by which noise scatters it", "[diagnose][fit]") {
  constexpr int kDraws = 40;
  double squares = 0.0, sum = 0.0;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Linearised about = driven(100 + 2 * static_cast<std::uint64_t>(draw));
    const Fit found = fit(about.problem, kLinear);
    const double bias = (found.unknowns[0].value - 0.3) / found.deviation(0, "torque");
    const double gain = (found.unknowns[1].value - 1.1) / found.deviation(1, "gain");
    squares += bias * bias + gain * gain;
    sum += bias + gain;
  }
  CHECK(std::abs(squares - 2.0 * kDraws) < 4.0 * std::sqrt(4.0 * kDraws));
  CHECK(std::abs(sum) < 4.0 * std::sqrt(2.0 * kDraws));
}

TEST_CASE("Half the adequate step moves runs by less than the stated share of the noise, twice of it by more",
          "[diagnose][fit]") {
  const Plant quick = Pendulum{.length = 0.05, .friction = 1e-3, .mass = 1.0};
  const double noise = GENERATE(1e-2, 1e-4, 1e-6, 1e-8);
  Linearised about(quick, {recorded(Machine(quick, {}), {.seconds = 2.0, .strength = 0.05, .position = 2.0})}, noise);
  about.problem.max_step = 0.011;
  const double step = adequate_step(about.problem);
  const auto moved = [&](double by) {
    FitProblem coarse = about.problem, fine = about.problem;
    coarse.max_step = by;
    fine.max_step = 0.5 * by;
    const Fit nominal = about.at_truth({});
    const Runs one(coarse, nominal), other(fine, nominal);
    const Eigen::MatrixXd difference = one(0, nominal.initial_states[0]) - other(0, nominal.initial_states[0]);
    const Eigen::VectorXd rows = about.response.project(0, difference);
    return rows.norm() / std::sqrt(static_cast<double>(rows.size()));
  };
  CAPTURE(noise, step);
  CHECK(step <= 0.011);
  CHECK(step >= kSettings.fit.shortest_step);
  if (step > kSettings.fit.shortest_step) CHECK(moved(step) < kSettings.fit.numerical_share);
  if (step < 0.0109) CHECK(moved(2.0 * step) > kSettings.fit.numerical_share);
  CHECK((noise > 1e-3 ? step == 0.011 : step < 0.011));
}

TEST_CASE("The same model has the same SSE however it is asked for, and a refined fit is no worse", "[diagnose][fit]") {
  const std::vector<Effect> truth{{CoulombFriction{0.2}, 0, -1}}, begun{{CoulombFriction{0.15}, 0, -1}};
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, truth), {.noise = 1e-3, .position = 1.0})}, 1e-3);
  const Fit found = fit(about.problem, begun);
  CHECK(begin(about.problem, found.effects, found.initial_states).sse == Approx(found.sse).epsilon(1e-9));
  CHECK(begin(about.problem, begun, {}).sse > found.sse);
  const Fit again = refined(about.problem, found);
  CHECK(again.refined);
  CHECK(again.sse + prior_cost(again) <= found.sse + prior_cost(found));
  CHECK(std::abs(again.unknowns[0].value - 0.2) < 4.0 * again.deviation(0, "level"));
  Fit anew = found;
  for (SegmentState& start : anew.initial_states) start += SegmentState{{0.01, 0.02}};
  CHECK(started(about.problem, anew).sse == Approx(found.sse).epsilon(0.05));

  const std::vector<Eigen::MatrixXd> left = residuals(about.problem, found);
  std::vector<Trajectory> elsewhere = about.paths;
  for (Trajectory& path : elsewhere) path.position.setConstant(7.0);
  const std::vector<Trajectory> paths = simulated(about.problem, found, elsewhere);
  for (std::size_t w = 0; w < left.size(); ++w) {
    const Segment& window = about.response.windows()[w];
    const auto first = static_cast<Eigen::Index>(window.first);
    const Eigen::VectorXd rows = about.response.project(w, left[w]);
    CHECK(largest_difference(rows, found.residual.segment(about.response.first_row(w), rows.size())) < 1e-9);
    CHECK(largest_difference(paths[0].position.middleRows(first, left[w].rows()) + left[w],
                             about.data[0].position.middleRows(first, left[w].rows())) < 1e-9);
    CHECK(paths[0].velocity(first, 0) == found.initial_states[w][1]);
  }
}
