// What an explanation promises: probabilities, tests and noise in closed form, and that of nothing nothing is made.

#include "diagnose/search/explain.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "physics/catalogue.hpp"
#include "support/dense.hpp"
#include "support/linearised_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::kPendulumNoise, testing::LinearisedPendulum, testing::record;
using testing::dense::log_density;

namespace {

const std::vector<std::size_t> kFew{EffectForm{ViscousFriction{}}.index(), EffectForm{CoulombFriction{}}.index(),
                                    EffectForm{LinearSpring{}}.index(), EffectForm{ConstantBias{}}.index()};

Fit fit_of(double sse, std::size_t unknowns, std::size_t effects = 0) {
  Fit fit;
  fit.sse = sse;
  fit.unknowns.resize(unknowns);
  fit.effects.resize(effects);
  return fit;
}

}  // namespace

TEST_CASE("Candidates carry the odds of their evidence and together are certain", "[diagnose][search]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {{CoulombFriction{0.004}, 0}}), -1.0, 71)};
  const Explanation found = explain(kPendulum, data, {kFew, {}});
  REQUIRE(found.candidates.size() > 1);
  double sum = 0.0;
  for (const Candidate& candidate : found.candidates) {
    CHECK(candidate.fit.log_evidence <= found.best().fit.log_evidence);
    const double behind = found.best().fit.log_evidence - candidate.fit.log_evidence;
    CHECK(candidate.probability == Approx(found.best().probability * std::exp(-behind)));
    sum += candidate.probability;
  }
  CHECK(sum == Approx(1.0));
  CHECK(found.without_effects().fit.effects.empty());
  CHECK(found.without_effects().probability < 1.0);
  CHECK(key(found.best().fit.effects) == "coulomb_friction@1 ");
}

TEST_CASE("Where nothing is missing nothing is found", "[diagnose][search]") {
  const auto seed = static_cast<std::uint64_t>(GENERATE(72, 73, 74));
  const std::vector<Measured> data{record(Machine(kPendulum, {}), -1.0, seed)};
  const Explanation found = explain(kPendulum, data, {kFew, {}});
  CHECK(found.best().fit.effects.empty());
  CHECK(found.best().probability > 0.5);
  CHECK(found.p_value(found.best().fit) > 1e-3);
  CHECK(found.start == kPendulum);
}

TEST_CASE("The noise is that of the sensor, and where there is none that of arithmetic", "[diagnose][search]") {
  const Machine machine(kPendulum, {});
  Measured noisy = record(machine, -1.0, 75);
  const double more = GENERATE(0.0, 2e-3);
  RandomStream random(76);
  for (double& q : noisy.position.reshaped()) q += more * draw_normal(random);
  CHECK(explain(kPendulum, {noisy}, {{}, {}}).noise[0] == Approx(std::hypot(kPendulumNoise, more)).epsilon(0.05));
  if (more > 0.0) return;
  StateVector start(2);
  start << 0.3, 0.0;
  noisy.position = machine.run(start, noisy.time, machine.drives(noisy.time, noisy.input), 0, 1199, 1e-3);
  const Eigen::ArrayXd about = noisy.position.col(0).array() - noisy.position.mean();
  CHECK(explain(kPendulum, {noisy}, {{}, {}}).noise[0] ==
        Approx(1e-5 * std::sqrt(about.square().mean())).epsilon(0.01));
}

TEST_CASE("Free parameters that explain all leave nothing to be missing", "[diagnose][search]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {}), -1.0, 77)};
  Plant given = kPendulum;
  std::get<Pendulum>(given).friction = 0.35;
  std::get<Pendulum>(given).mass = 0.5;
  CHECK_FALSE(explain(given, data, {kFew, {}}).best().fit.effects.empty());
  const Explanation found = explain(given, data, {kFew, {"friction", "mass"}});
  CHECK(found.given == given);
  CHECK(std::get<Pendulum>(found.start).friction == Approx(0.2).epsilon(0.02));
  CHECK(std::get<Pendulum>(found.start).mass == Approx(0.6).epsilon(0.02));
  CHECK(found.best().fit.effects.empty());
  CHECK(found.p_value(found.best().fit) > 1e-3);
}

TEST_CASE("Without free parameters a set's evidence is that beside them, whatever they may be", "[diagnose][search]") {
  LinearisedPendulum pendulum(1);
  pendulum.about.dictionary = make_dictionary(*pendulum.about.response, *pendulum.about.forcing, kFew);
  const LinearResponse& response = *pendulum.about.response;
  const std::vector<std::string> free{"friction", "gravity"};
  const Projected projected = free_projected_out(pendulum.about, kPendulum, pendulum.data, free);
  // What the parameters do, by differences of their own.
  Eigen::MatrixXd by(response.rows(), 2);
  for (Eigen::Index i = 0; i < 2; ++i) {
    Pendulum low = std::get<Pendulum>(kPendulum), high = low;
    (i == 0 ? low.friction : low.gravity) -= 0.1;
    (i == 0 ? high.friction : high.gravity) += 0.1;
    const Forcing& forcing = *pendulum.about.forcing;
    const Eigen::MatrixXd difference = forcing.acceleration(Plant{high}, 0) - forcing.acceleration(Plant{low}, 0);
    by.col(i) = response.responses({difference.transpose().reshaped()}).col(0).normalized();
  }
  CHECK((by.transpose() * projected.target).norm() < 1e-6 * response.target().norm());
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(response.rows(), response.rows());
  const Eigen::MatrixXd any = one + 1e12 * by * by.transpose();
  for (Eigen::Index c = 0; c < pendulum.about.dictionary.columns.cols(); ++c) {
    const Eigen::VectorXd x = pendulum.about.dictionary.columns.col(c), left = projected.columns.col(c);
    const double beside = log_density(response.target(), any + x * x.transpose()) - log_density(response.target(), any);
    const double without =
        log_density(projected.target, one + left * left.transpose()) - log_density(projected.target, one);
    CHECK(without == Approx(beside).margin(0.02));
  }
  // A viscous friction does what the nominal's own does.
  CHECK(projected.columns.col(0).norm() < 1e-6 * pendulum.about.dictionary.columns.col(0).norm());
  CHECK(free_projected_out(pendulum.about, kPendulum, pendulum.data, {}).target == response.target());
}

TEST_CASE("Four strong effects of a machine that is let go are found along its motion", "[diagnose][search]") {
  const std::vector<Effect> hidden{{AddedInertia{0.15}, 0},
                                   {CoggingTorque{0.7, 11.4, 0.4}, 0},
                                   {StribeckFriction{0.5, 1.0, 0.3}, 0},
                                   {ViscousFriction{0.3}, 0}};
  const Machine machine(kPendulum, hidden);
  const std::vector<Measured> data{testing::let_go(machine, -2.4, 41), testing::let_go(machine, 2.7, 42)};
  const Explanation found = explain(kPendulum, data, {usual_effects(), {}});
  CHECK(found.excess(found.best().fit) < 0.5);
  CHECK(found.find(hidden) != nullptr);
  CHECK(found.best().fit.log_evidence - found.find(hidden)->fit.log_evidence < 6.0);
}

TEST_CASE("A nominal that cannot be simulated is declined", "[diagnose][search]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {}), -1.0, 78)};
  CHECK_THROWS_AS(explain(Custom({}, {"1e8*q"}, {}), data, {kFew, {}}), NumericalError);
}

TEST_CASE("The test of what is left is Fisher's: in closed form for two degrees of freedom", "[diagnose][search]") {
  Explanation explanation;
  for (const double fast : {2.0, 10.0, 500.0}) {
    explanation.fast_rows = fast;
    for (const double sse : {0.0, 0.5, 3.0, 20.0}) {
      for (const std::size_t unknowns : {0, 3}) {
        explanation.rows = 2.0 + static_cast<double>(unknowns);
        CHECK(explanation.p_value(fit_of(sse, unknowns)) == Approx(std::pow(1.0 + sse / fast, -0.5 * fast)));
      }
    }
  }
}

TEST_CASE("The excess is what is left beyond the noise; each effect and each number costs its part",
          "[diagnose][search]") {
  Explanation explanation;
  explanation.rows = 103.0;
  CHECK(explanation.excess(fit_of(500.0, 3)) == Approx(2.0));
  CHECK(explanation.excess(fit_of(100.0, 3)) == 0.0);
  CHECK(explanation.excess(fit_of(50.0, 3)) == 0.0);  // less than the noise is nothing
  CHECK(cost(1.0, fit_of(0.0, 0)) == 0.0);
  CHECK(cost(2.0, fit_of(0.0, 3, 2)) == Approx(std::log(2.0) + 2 * 0.1 + 3 * 0.22));
  explanation.noise = Eigen::Vector2d(3.0, 4.0);
  CHECK(explanation.noise_rms() == Approx(5.0 / std::sqrt(2.0)));
}
