// Parameters where the machine does more than the model says: a random force, bounds that stop a step.

#include "diagnose/fit/process_noise.hpp"

#include <catch2/catch.hpp>

#include "diagnose/search/explain.hpp"
#include "diagnose/verdict/which.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::record;

namespace {

constexpr double kPeriod = 0.01;  // s, of the recordings
constexpr double kForce = 0.02;   // N m sqrt(s), root of the spectral density
constexpr double kInertia = 0.6 * 0.8 * 0.8;
constexpr double kLevel = 0.3;  // N m, of friction

/// A pendulum on which a force acts that the recording does not hold.
Measured shaken(std::uint64_t seed) {
  const Machine machine(kPendulum, {{CoulombFriction{kLevel}, 0}});
  Measured data = record(machine, -1.0, seed);
  RandomStream random(seed + 1000);
  Eigen::MatrixXd felt = data.input;
  for (double& u : felt.reshaped()) u += kForce / std::sqrt(kPeriod) * draw_normal(random);
  StateVector start(2);
  start << 0.3, 0.0;
  data.position = machine.run(start, data.time, machine.drives(data.time, felt), 0, data.samples() - 1, 1e-3);
  for (double& q : data.position.reshaped()) q += testing::kPendulumNoise * draw_normal(random);
  return data;
}

}  // namespace

TEST_CASE("Beside a random force intervals hold the truth", "[diagnose][process_noise][slow]") {
  constexpr int kRuns = 24;
  int covered = 0, covered_by_free_runs = 0;
  double intensity = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    const std::vector<Measured> data{shaken(static_cast<std::uint64_t>(7 + run))};
    const std::size_t friction = EffectForm{CoulombFriction{}}.index();
    const ExplainOptions options{{friction}, {}};
    const Explanation found = explain(kPendulum, data, options);
    REQUIRE(found.best().fit.effects.size() == 1);
    const FitProblem problem = problem_about(*found.measured, found, data, options);
    const Eigen::VectorXd intense = likely_intensity(problem, LikelyIntensity(problem.response), found.best().fit);
    const Fit fit = fit_with_process_noise(problem, problem.response.with_process_noise(intense), found.best().fit);
    const auto holds = [](const Fit& f) {
      return std::abs(f.unknowns[0].value - kLevel) < 1.96 * f.deviation(0, "level");
    };
    covered += holds(fit);
    covered_by_free_runs += holds(found.best().fit);
    intensity += intense[0] / kRuns;
  }
  CHECK(covered >= 20);  // of 24; fewer have probability 0.006
  CHECK(covered_by_free_runs < 20);
  CHECK(intensity == Approx(kForce / kInertia).epsilon(0.15));
}

TEST_CASE("A response beside no random force is the response", "[diagnose][process_noise]") {
  const std::vector<Measured> data{shaken(3)};
  const Explanation found = explain(kPendulum, data, {{}, {}});
  const LinearResponse& response = *found.measured->response;
  CHECK(response.with_process_noise(Eigen::VectorXd::Zero(1)).target().isApprox(response.target()));
  const double much = response.with_process_noise(Eigen::VectorXd::Constant(1, 1.0)).target().squaredNorm();
  CHECK(much < 0.01 * response.target().squaredNorm());
}

TEST_CASE("Evidence is highest beside the noise that is likely, and so is that of the law that was hidden",
          "[diagnose][process_noise]") {
  const std::vector<Measured> data{shaken(11)};
  const auto beside_law = [&](const EffectForm& law) {
    const ExplainOptions options{{law.index()}, {}};
    const Explanation found = explain(kPendulum, data, options);
    const FitProblem problem = problem_about(*found.measured, found, data, options);
    const Fit& best = found.best().fit;
    const LikelyIntensity likely(problem.response);
    const BesideNoise settled = beside_likely_noise(problem, likely, best);
    INFO(law.name());
    CHECK(settled.log_likelihood().sum() > settled.fit.log_evidence);  // less the price of numbers
    const Eigen::VectorXd intensity = likely_intensity(problem, likely, best);
    for (const double factor : {0.0, 0.5, 0.8, 1.25, 2.0}) {
      const LinearResponse white = problem.response.with_process_noise(factor * intensity);
      INFO("intensity times " << factor);
      CHECK(fit_with_process_noise(problem, white, best).log_evidence < settled.fit.log_evidence);
    }
    return settled.fit.log_evidence;
  };
  const double hidden = beside_law(CoulombFriction{});
  CHECK(hidden > beside_law(CubicSpring{}) + 10.0);
  CHECK(hidden > beside_law(ViscousFriction{}) + 3.0);
}

TEST_CASE("Beside a random force a mass cannot be told from the motor's strength, nor that from the sensor's scale",
          "[diagnose][process_noise]") {
  for (const double gain : {0.8, 1.25}) {
    const Plant nominal = Mass{.mass = 2.0};
    Measured data = record(Machine(nominal, {{InputGain{gain}, 0}}), -1.0, 21);
    RandomStream random(22);  // a force that lasts
    double force = 0.0, velocity = 0.0, moved = 0.0;
    for (Eigen::Index k = 0; k < data.position.rows(); ++k) {
      data.position(k, 0) += moved;
      force = 0.9 * force + 0.1 * draw_normal(random);
      velocity += kPeriod * force;
      moved += kPeriod * velocity;
    }
    const std::vector<Measured> all{data};
    const auto beside = [&](const EffectForm& law) {
      const ExplainOptions options{{law.index()}, {}};
      const Explanation found = explain(nominal, all, options);
      const FitProblem problem = problem_about(*found.measured, found, all, options);
      const Fit start = fit(problem, {{law, 0}});
      return beside_likely_noise(problem, LikelyIntensity(problem.response), start).fit;
    };
    const Fit motor = beside(InputGain{1.1}), sensor = beside(SensorScale{1.1}), inertia = beside(AddedInertia{0.1});
    const double found = motor.unknowns[0].value;
    INFO("gain " << gain << ", found " << found << " +- " << motor.deviation(0, "gain"));
    CHECK(std::abs(found - gain) < 3.0 * motor.deviation(0, "gain"));
    CHECK(sensor.unknowns[0].value == Approx(found).epsilon(0.01));
    CHECK(sensor.log_evidence == Approx(motor.log_evidence).margin(1.0));
    if (gain > 1.0) continue;  // an inertia that is added makes nothing lighter
    CHECK(2.0 / (2.0 + inertia.unknowns[0].value) == Approx(found).epsilon(0.01));
    CHECK(inertia.log_evidence == Approx(motor.log_evidence).margin(3.0));  // its prior has another width
  }
}

TEST_CASE("Of two models that are equally wrong one seems better by three nats no more often than it may",
          "[diagnose][process_noise]") {
  constexpr int kDraws = 20000, kRows = 7;
  RandomStream random(5);
  int misled = 0, misled_by_likelihood = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    Eigen::VectorXd more(kRows);
    for (double& nats : more) nats = 20.0 * draw_normal(random);
    misled += vuong_bounded(more.sum(), more) > 3.0;
    misled_by_likelihood += more.sum() > 3.0;
  }
  CHECK(misled / double(kDraws) == Approx(1.0 / (1.0 + std::exp(3.0))).epsilon(0.1));
  CHECK(misled_by_likelihood > 9 * kDraws / 20);
}

TEST_CASE("An advantage in every row is believed, one in a single row is not", "[diagnose][process_noise]") {
  Eigen::VectorXd more = Eigen::VectorXd::Constant(10, 2.0);
  CHECK(vuong_bounded(more.sum(), more) == 20.0);
  more[3] += 1e-3;
  CHECK(vuong_bounded(more.sum(), more) == Approx(20.001));
  more.setZero();
  more[3] = 20.0;
  CHECK(vuong_bounded(more.sum(), more) < 2.0);
  CHECK(vuong_bounded(7.0, more.head(1)) == 7.0);  // one row: nothing is known of scatter
}
