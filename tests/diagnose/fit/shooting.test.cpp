// Initial states of all segments: what the truth leaves is white noise, and segments that went astray come back.

#include "diagnose/fit/shooting.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "diagnose/fit/runs.hpp"
#include "physics/catalogue.hpp"
#include "support/compare.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::largest_difference, testing::Linearised, testing::recorded;

namespace {

constexpr double kSensor = 1e-3;  // rad, noise

double sse_of_window(const Linearised& about, const Fit& fit, std::size_t w) {
  return fit.residual.segment(about.response.first_row(w), about.response.row_count(w)).squaredNorm();
}

/// A pendulum that sticks now and then, with its model.
struct Sticking {
  Effect law{CoulombFriction{1.2}, 0, -1};
  Linearised about{kPendulum, {recorded(Machine(kPendulum, {law}), {.seconds = 12.0, .noise = kSensor})}, kSensor};

  Fit simulated() const {
    Fit fit = about.at_truth({law});
    simulate(about.problem, fit, 0);
    return fit;
  }
};

}  // namespace

TEST_CASE("The SSE that noise alone gives is that of so many squares of white noise and one deviation more",
          "[diagnose][fit]") {
  for (const int rows : {10, 40, 400}) {
    RandomStream random(static_cast<std::uint64_t>(rows));
    double sum = 0.0, squares = 0.0;
    constexpr int kDraws = 4000;
    for (int draw = 0; draw < kDraws; ++draw) {
      double sse = 0.0;
      for (int i = 0; i < rows; ++i) sse += std::pow(draw_normal(random), 2);
      sum += sse / kDraws;
      squares += sse * sse / kDraws;
    }
    const double deviation = std::sqrt(squares - sum * sum);
    CHECK(std::abs(noise_sse(rows) - sum - deviation) < 0.1 * deviation);
  }
}

TEST_CASE("Simulated paths are what the sensors show, and segments begin there again", "[diagnose][fit]") {
  const std::vector<Effect> laws{{SensorScale{1.2}, 0, -1}, {SensorOffset{0.3}, 0, -1}};
  const Machine machine(kPendulum, laws);
  const testing::Recorded made = recorded(machine, {.seconds = 8.0});
  const Linearised about(kPendulum, {made}, kSensor);
  Fit fit = about.at_truth(laws);
  simulate(about.problem, fit, 1);
  const std::vector<Trajectory> paths = simulated(about.problem, fit, about.paths);
  CHECK(largest_difference(paths[0].position, made.data.position) < 1e-4);
  CHECK(largest_difference(paths[0].velocity, 1.2 * made.truth.velocity) < 1e-3);
  for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
    const SegmentState again = initial_guess(about.response.windows()[w], paths[0], machine);
    CHECK(largest_difference(again, fit.initial_states[w]) < 1e-9);
  }
}

TEST_CASE("Without noise the truth leaves nothing where a gap hides how a play moves", "[diagnose][fit]") {
  const Effect law{Backlash{1.2}, 0, -1};
  const Machine machine(kPendulum, {law});
  const Linearised about(kPendulum,
                         {recorded(machine, {.seconds = 8.0, .gap = 4.2, .play = 0.4}),
                          recorded(machine, {.seconds = 8.0, .gap = 3.1, .phase = 2.0})},
                         kSensor);
  Fit fit = about.at_truth({law});
  simulate(about.problem, fit, 2);
  polish(about.problem, fit);
  CHECK(fit.sse < 1e-2);
}

TEST_CASE("Without noise the truth leaves nothing, with noise it leaves white noise of variance 1 in every recording",
          "[diagnose][fit]") {
  const Effect law = GENERATE(Effect{CoulombFriction{0.2}, 0, -1}, Effect{PreslidingHysteresis{10.0, 0.2}, 0, -1},
                              Effect{InputDelay{0.02}, 0, -1}, Effect{SensorScale{1.2}, 0, -1});
  INFO(name_of(law.form));
  const Machine machine(kPendulum, {law});
  const auto fit_of = [&](double noise) {
    const Linearised about(kPendulum,
                           {recorded(machine, {.seconds = 12.0, .noise = noise, .seed = 8}),
                            recorded(machine, {.seconds = 8.0, .noise = noise, .phase = 2.0, .seed = 9})},
                           kSensor);
    Fit fit = about.at_truth({law});
    simulate(about.problem, fit, 1);
    return fit;
  };
  CHECK(fit_of(0.0).sse < 1e-3);
  const Fit noisy = fit_of(kSensor);
  const auto rows = static_cast<double>(noisy.residual.size());
  CHECK(noisy.sse == Approx(noisy.residual.squaredNorm()));
  CHECK(std::abs(noisy.sse - rows) < 4.0 * std::sqrt(2.0 * rows));
  CHECK(std::abs(noisy.residual.sum()) < 4.0 * std::sqrt(rows));
  for (const Eigen::Index lag : {1, 2, 5}) {
    const double product =
        noisy.residual.head(noisy.residual.size() - lag).dot(noisy.residual.tail(noisy.residual.size() - lag));
    CHECK(std::abs(product) < 4.0 * std::sqrt(rows));
  }
}

TEST_CASE(
    "Of a linear machine one round gives the least-squares initial states wherever they begin, and the rows of "
    "the linear response",
    "[diagnose][fit]") {
  const Plant slide = Mass{1.4, 0.8};
  const Linearised about(slide, {recorded(Machine(slide, {{ConstantBias{0.4}, 0, -1}}), {.noise = kSensor})}, kSensor);
  Fit near = about.at_truth({}), far = near;
  for (SegmentState& start : far.initial_states) start += SegmentState{{3.0, -5.0}};
  simulate(about.problem, near, 0);
  CHECK(largest_difference(near.residual, about.response.target()) < 1e-6 * about.response.target().norm());
  simulate(about.problem, near, 1);
  simulate(about.problem, far, 1);
  const Runs runs(about.problem, near);
  for (std::size_t w = 0; w < near.initial_states.size(); ++w) {
    CHECK(largest_difference(near.initial_states[w], far.initial_states[w]) < 1e-7);
    // No change of the initial state leaves less of the samples.
    const double left = runs.residual(w, near.initial_states[w]).squaredNorm();
    for (const SegmentState& step : {SegmentState{{1e-3, 0.0}}, SegmentState{{0.0, 1e-3}}}) {
      CHECK(runs.residual(w, near.initial_states[w] + step).squaredNorm() > left);
      CHECK(runs.residual(w, near.initial_states[w] - step).squaredNorm() > left);
    }
  }
  CHECK(far.sse == Approx(near.sse).epsilon(1e-6));
}

TEST_CASE("Rounds of a pendulum's initial states come ever nearer to where the machine was", "[diagnose][fit]") {
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, {}), {})}, kSensor);
  double before = kInfinity;
  for (const int rounds : {0, 1, 2, 4}) {
    Fit fit = about.at_truth({});
    for (SegmentState& start : fit.initial_states) start += SegmentState{{0.2, -0.5}};
    simulate(about.problem, fit, rounds);
    double off = 0.0;
    for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
      const auto row = static_cast<Eigen::Index>(about.response.windows()[w].first);
      off += std::hypot(fit.initial_states[w][0] - about.paths[0].position(row, 0),
                        fit.initial_states[w][1] - about.paths[0].velocity(row, 0));
    }
    CAPTURE(rounds, off, before);
    CHECK(off < 0.3 * before);
    before = off;
  }
  CHECK(before < 1e-5);
}

TEST_CASE("A round moves an initial state only to where the segment leaves less, though the linear response misleads",
          "[diagnose][fit]") {
  // An arm that tumbles: a start that is a little off leads elsewhere, and no straight line tells where.
  const Plant arm = TwoLinkArm{};
  const Linearised about(arm, {recorded(Machine(arm, {}), {.seconds = 12.0, .strength = 6.0})}, kSensor);
  Fit fit = about.at_truth({{AddedInertia{0.3}, 1, -1}});
  const Runs runs(about.problem, fit);
  const auto left = [&](const Fit& of, std::size_t w) { return runs.residual(w, of.initial_states[w]).squaredNorm(); };
  int moved = 0, kept = 0;
  for (const int rounds : {1, 2}) {
    Fit after = fit;
    simulate(about.problem, after, rounds);
    for (std::size_t w = 0; w < after.initial_states.size(); ++w) {
      CAPTURE(rounds, w);
      CHECK(left(after, w) <= left(fit, w));
      (after.initial_states[w] == fit.initial_states[w] ? kept : moved)++;
    }
  }
  CHECK(moved > 0);
  CHECK(kept > 0);
}

TEST_CASE("Simulations end as soon as they leave more than is asked for, and are the same where they do not",
          "[diagnose][fit]") {
  const Sticking machine;
  const Fit whole = machine.simulated();
  for (const double most : {0.2, 0.999, 1.001}) {
    Fit fit = machine.about.at_truth({machine.law});
    CAPTURE(most);
    if (most < 1.0) {
      CHECK_THROWS_AS(simulate(machine.about.problem, fit, 0, most * whole.sse), NumericalError);
    } else {
      simulate(machine.about.problem, fit, 0, most * whole.sse);
      CHECK(fit.residual == whole.residual);
    }
  }
}

TEST_CASE("Polishing leaves segments that fit as they are, lowers the SSE of others and raises that of none",
          "[diagnose][fit]") {
  const Sticking machine;
  Fit fit = machine.simulated();
  const std::size_t last = fit.initial_states.size() - 1;
  for (const std::size_t w : {std::size_t{1}, last}) fit.initial_states[w] += SegmentState{{0.05, 0.4}};
  simulate(machine.about.problem, fit, 0);
  const Fit before = fit;
  polish(machine.about.problem, fit);
  int left = 0;
  double sum = 0.0;
  for (std::size_t w = 0; w <= last; ++w) {
    const double was = sse_of_window(machine.about, before, w), is = sse_of_window(machine.about, fit, w);
    const double usual = noise_sse(machine.about.response.row_count(w));
    CAPTURE(w, was, is, usual);
    CHECK(is <= was);
    if (was <= usual) {
      CHECK(fit.initial_states[w] == before.initial_states[w]);
      ++left;
    }
    if (w == 1 || w == last) {
      CHECK(was > 3.0 * usual);
      CHECK(is < 1.5 * usual);
    }
    sum += is;
  }
  CHECK(left > 0);
  CHECK(fit.sse == Approx(sum));
}

TEST_CASE("Though the model is wrong, neither polishing nor recovering raises the SSE of a segment",
          "[diagnose][fit]") {
  const Effect missing = GENERATE(Effect{CoulombFriction{0.8}, 0, -1}, Effect{GravityTilt{0.3}, 0, -1});
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, {missing}), {.seconds = 12.0, .noise = kSensor})},
                         kSensor, 1.0);
  Fit fit = about.at_truth({});
  simulate(about.problem, fit, 0);
  for (int round = 0; round < 2; ++round) {
    const Fit before = fit;
    polish(about.problem, fit);
    recover(about.problem, fit);
    int lowered = 0;
    for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
      const double was = sse_of_window(about, before, w), is = sse_of_window(about, fit, w);
      CAPTURE(round, w);
      CHECK(is <= was);
      lowered += is < was;
    }
    if (round == 0) CHECK(lowered > 3);
  }
}

TEST_CASE("A lag's first output is polished though the segment fits already", "[diagnose][fit]") {
  const Effect law{ActuatorLag{0.3}, 0, -1};
  const Machine machine(kPendulum, {law});
  const Linearised about(kPendulum, {recorded(machine, {.noise = kSensor, .departed = 1e-3})}, kSensor);
  Fit fit = about.at_truth({law});
  simulate(about.problem, fit, 1);
  const Fit before = fit;
  REQUIRE(sse_of_window(about, before, 0) < noise_sse(about.response.row_count(0)));
  polish(about.problem, fit);
  CHECK(fit.initial_states[0][2] != before.initial_states[0][2]);
  CHECK(fit.sse < before.sse);
}

TEST_CASE("A few segments that went astray come back; where many do, or none does, nothing is touched",
          "[diagnose][fit]") {
  const Sticking machine;
  const Linearised& about = machine.about;
  const int astray = GENERATE(0, 1, 2, 3, 6);
  Fit fit = machine.simulated();
  const double usual = fit.sse;
  REQUIRE(fit.initial_states.size() == 6);
  for (std::size_t w = 0; w < static_cast<std::size_t>(astray); ++w) {
    fit.initial_states[w] += SegmentState{{w % 2 == 0 ? 2.0 : -1.5, 6.0}};
  }
  simulate(about.problem, fit, 0);
  const Fit before = fit;
  CAPTURE(astray, before.sse);
  const bool few = astray > 0 && 3 * astray <= 6;
  CHECK(recover(about.problem, fit) == few);
  if (few) {
    CHECK(before.sse > 10.0 * usual);
    CHECK(fit.sse < usual + 4.0);
  } else {
    CHECK(fit.sse == before.sse);
    for (std::size_t w = 0; w < 6; ++w) CHECK(fit.initial_states[w] == before.initial_states[w]);
  }
}

TEST_CASE("A model that no initial state can save is said not to be recovered", "[diagnose][fit]") {
  // A blow in one segment, which the model lacks.
  const Machine machine(kPendulum, {{TorqueStep{1.0, 4.5}, 0, -1}, {TorqueStep{-1.0, 5.5}, 0, -1}});
  const Linearised about(kPendulum, {recorded(machine, {.seconds = 12.0, .noise = kSensor})}, kSensor);
  Fit fit = about.at_truth({});
  simulate(about.problem, fit, 2);
  const double before = fit.sse;
  REQUIRE(sse_of_window(about, fit, 2) > 0.9 * before);
  CHECK_FALSE(recover(about.problem, fit));
  CHECK(fit.sse <= before);
}

TEST_CASE("A model that diverges from every start is a numerical failure", "[diagnose][fit]") {
  const Linearised about(kPendulum, {recorded(Machine(kPendulum, {}), {})}, kSensor);
  Fit fit = about.at_truth({});
  fit.plant = Custom({{{"k", 1e6}}}, {"u + k*q^3 + k*v"}, {});
  CHECK_THROWS_AS(simulate(about.problem, fit, 1), NumericalError);
}
