// Free runs of segments: closed forms, and what hidden states and lags know from one segment to the next.

#include "diagnose/fit/runs.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "physics/catalogue.hpp"
#include "support/compare.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::largest_difference, testing::Linearised, testing::Recorded, testing::recorded;

namespace {

/// Largest residual of each window, each beginning as the fit says.
std::vector<double> largest_residuals(const Linearised& about, const Fit& fit) {
  const Runs runs(about.problem, fit);
  std::vector<double> largest;
  for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
    largest.push_back(runs.residual(w, fit.initial_states[w]).cwiseAbs().maxCoeff());
  }
  return largest;
}

}  // namespace

TEST_CASE("A slide's segments are its closed form, in every recording and beyond a gap", "[diagnose][fit]") {
  const double mass = 1.4, friction = 0.8, rate = friction / mass;
  const Machine slide(Mass{mass, friction}, {});
  const Linearised about(Mass{mass, friction},
                         {recorded(slide, {.seconds = 5.0}), recorded(slide, {.gap = 2.3, .phase = 1.0})}, 1e-3);
  const Fit fit = about.at_truth({});
  const Runs runs(about.problem, fit);
  REQUIRE(about.response.windows().size() == 5);
  for (std::size_t w = 0; w < 5; ++w) {
    const Segment& window = about.response.windows()[w];
    const Measured& data = about.data[window.recording];
    double q = -0.7, v = 1.3;
    Eigen::MatrixXd states;
    const Eigen::MatrixXd simulated = runs(w, SegmentState{{q, v}}, &states);
    REQUIRE(simulated.rows() == static_cast<Eigen::Index>(window.samples()));
    REQUIRE(states.rows() == simulated.rows());
    for (std::size_t k = window.first; k <= window.last; ++k) {
      const auto row = static_cast<Eigen::Index>(k - window.first);
      CHECK(simulated(row, 0) == Approx(q).margin(1e-9));
      CHECK(states(row, 1) == Approx(v).margin(1e-9));
      if (k == window.last) break;
      const double h = data.time[k + 1] - data.time[k];
      const double u = data.input(static_cast<Eigen::Index>(k), 0), lost = -std::expm1(-rate * h) / rate;
      q += v * lost + u / friction * (h - lost);
      v += (u / friction - v) * rate * lost;
    }
    const Eigen::MatrixXd left = runs.residual(w, SegmentState{{-0.7, 1.3}}) + simulated;
    CHECK(largest_difference(left, data.position.middleRows(static_cast<Eigen::Index>(window.first), left.rows())) <
          1e-12);
  }
}

TEST_CASE("Segments that begin where the one before has come to are one long run, however it is cut",
          "[diagnose][fit]") {
  const Effect law = GENERATE(Effect{CoulombFriction{0.2}, 0, -1}, Effect{CubicSpring{0.5}, 0, -1},
                              Effect{InputDelay{0.013}, 0, -1}, Effect{TorqueStep{0.3, 2.718}, 0, -1});
  INFO(name_of(law.form));
  const std::vector<Recorded> made{recorded(Machine(kPendulum, {law}), {.noise = 0.01})};
  const Linearised whole(kPendulum, made, 0.01, 6.0);
  const double length = GENERATE(0.5, 1.0, 2.0);
  const Linearised parts(kPendulum, made, 0.01, length);
  REQUIRE(whole.response.windows().size() == 1);
  REQUIRE(parts.response.windows().size() == static_cast<std::size_t>(std::lround(6.0 / length)));
  Eigen::MatrixXd states;
  const Runs run(whole.problem, whole.at_truth({law}));
  const SegmentState start{{0.35, -0.2}};
  run(0, start, &states);
  const double squares = run.residual(0, start).squaredNorm();
  const Runs runs(parts.problem, parts.at_truth({law}));
  double sum = 0.0;
  for (std::size_t w = 0; w < parts.response.windows().size(); ++w) {
    const auto first = static_cast<Eigen::Index>(parts.response.windows()[w].first);
    sum += runs.residual(w, SegmentState(states.row(first).transpose())).squaredNorm();
  }
  CHECK(sum == Approx(squares).epsilon(1e-6));
}

TEST_CASE("An effect of one recording acts in its segments alone", "[diagnose][fit]") {
  const Machine machine(kPendulum, {});
  const Linearised about(kPendulum, {recorded(machine, {.seconds = 4.0}), recorded(machine, {.seconds = 4.0})}, 1e-3);
  const int of = GENERATE(0, 1, -1);
  const std::vector<double> largest = largest_residuals(about, about.at_truth({{ConstantBias{0.5}, 0, of}}));
  REQUIRE(largest.size() == 4);
  for (std::size_t w = 0; w < 4; ++w) {
    const bool acts = of < 0 || about.response.windows()[w].recording == static_cast<std::size_t>(of);
    CAPTURE(of, w);
    CHECK((acts ? largest[w] > 0.05 : largest[w] < 1e-6));
  }
}

TEST_CASE("Friction's hidden state is known along a stretch, and of a segment after a gap it is that found there",
          "[diagnose][fit]") {
  const Effect law{PreslidingHysteresis{1.0, 1.0}, 0, -1};  // it remembers a radian of motion
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, {law}), {.seconds = 9.5, .gap = 4.0})}, 1e-3, 1.0);
  Fit fit = about.at_truth({law});
  const std::vector<Segment>& windows = about.response.windows();
  REQUIRE(windows.size() == 9);
  REQUIRE(windows[4].opens);
  const std::vector<double> not_found = largest_residuals(about, fit);
  const Runs runs(about.problem, fit);
  REQUIRE(fit.initial_states[4].size() == 5);
  fit.initial_states[4] = fit_initial_state([&](const SegmentState& x) { return runs.residual(4, x); },
                                            fit.initial_states[4], 20, runs.precision(4, fit.initial_states[4]))
                              .start;
  CHECK(std::abs(fit.initial_states[4][2]) > 0.1);
  const std::vector<double> found = largest_residuals(about, fit);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    CAPTURE(w, found[w], not_found[w]);
    CHECK(found[w] < 2e-4);
    if (w < 4) CHECK(found[w] == not_found[w]);
    if (w == 4 || w == 5) CHECK(not_found[w] > 20.0 * found[w]);
  }
}

TEST_CASE("A lag's departure from a recording's first input decays through the segments that follow",
          "[diagnose][fit]") {
  const double lag = 0.6, departed = GENERATE(-1.5, 2.0);
  const Effect law{ActuatorLag{lag}, 0, -1};
  const Machine machine(kPendulum, {law});
  const Linearised about(
      kPendulum,
      {recorded(machine, {.seconds = 4.0, .departed = departed}), recorded(machine, {.seconds = 4.0, .phase = 2.0})},
      1e-3, 0.5);
  Fit fit = about.at_truth({law});
  REQUIRE(fit.initial_states.size() == 16);
  REQUIRE(fit.initial_states[0].size() == 4);
  REQUIRE(fit.initial_states[1].size() == 2);
  const std::vector<double> settled = largest_residuals(about, fit);
  fit.initial_states[0][2] = departed;
  for (const auto& [w, left] : {std::pair{0, 1.0}, {1, std::exp(-0.5 / lag)}, {4, std::exp(-2.0 / lag)}}) {
    CAPTURE(w);
    CHECK(settled[static_cast<std::size_t>(w)] > 0.02 * left * std::abs(departed));
  }
  for (const double residual : largest_residuals(about, fit)) CHECK(residual < 1e-7);
  for (std::size_t w = 8; w < 16; ++w) CHECK(settled[w] < 1e-7);  // another recording, another departure
}

TEST_CASE("Of a segment's initial state only lags have a precision, that of their own recording's input",
          "[diagnose][fit]") {
  const Effect law{ActuatorLag{0.1}, 0, -1};
  const Machine machine(kPendulum, {law});
  const Linearised about(kPendulum, {recorded(machine, {}), recorded(machine, {.strength = 2.0})}, 1e-3);
  const Fit fit = about.at_truth({law});
  const Runs runs(about.problem, fit);
  REQUIRE(about.response.windows()[3].recording == 1);
  const SegmentState weak = runs.precision(0, fit.initial_states[0]), strong = runs.precision(3, fit.initial_states[3]);
  CHECK(weak.head(2).isZero(0.0));
  CHECK(weak[2] == Approx(4.0 * strong[2]));
  CHECK(runs.precision(1, fit.initial_states[1]).isZero(0.0));
}

TEST_CASE("Each segment's residual stands in its own rows, and a sum that is no number is refused", "[diagnose][fit]") {
  const Machine machine(kPendulum, {});
  const Linearised about(kPendulum, {recorded(machine, {}), recorded(machine, {.seconds = 4.0})}, 1e-3);
  Fit fit = about.at_truth({});
  double sum = 0.0;
  Eigen::Index reached = 0;
  for (std::size_t w = 0; w < about.response.windows().size(); ++w) {
    const auto samples = static_cast<Eigen::Index>(about.response.windows()[w].samples());
    const Eigen::MatrixXd residual = Eigen::MatrixXd::Random(samples, 1);
    take(about.problem, fit, w, residual);
    const Eigen::VectorXd rows = about.response.project(w, residual);
    CHECK(fit.residual.segment(reached, rows.size()) == rows);
    CHECK(fit.residual.tail(fit.residual.size() - reached - rows.size()).isZero(0.0));
    reached += rows.size();
    sum += rows.squaredNorm();
  }
  CHECK(reached == about.response.rows());
  sum_up(fit);
  CHECK(fit.sse == Approx(sum));
  for (const double none : {std::nan(""), kInfinity}) {
    fit.residual[5] = none;
    CHECK_THROWS_AS(sum_up(fit), NumericalError);
  }
}

TEST_CASE("A segment that diverges is a numerical failure", "[diagnose][fit]") {
  const Plant steep = Custom({{{"k", 1.0}}}, {"u + k*q^5"}, {});
  const Linearised about(steep, {recorded(Machine(steep, {}), {.seconds = 1.0, .strength = 0.0, .position = 0.01})},
                         1e-3, 1.0);
  const Fit fit = about.at_truth({});
  const Runs runs(about.problem, fit);
  CHECK(runs.residual(0, fit.initial_states[0]).cwiseAbs().maxCoeff() < 1e-9);
  CHECK_THROWS_AS(runs.residual(0, SegmentState{{50.0, 1e4}}), NumericalError);
}
