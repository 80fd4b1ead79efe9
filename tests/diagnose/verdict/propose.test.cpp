// What to record next: an input that tells two explanations apart, and none where nothing can.

#include "diagnose/verdict/propose.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/dense.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::kPendulumNoise;

namespace {

/// A pendulum's recording, and explanations of it by one effect each.
struct Doubted {
  std::vector<Measured> data{testing::record(Machine(kPendulum, {}), -1.0, 3)};
  Explanation explanation;
  std::vector<JointUnits> units{{"rad", "rad/s", "N m", "V"}};

  void add(std::vector<Effect> effects, double probability) {
    explanation.noise = Eigen::VectorXd::Constant(1, kPendulumNoise);
    Candidate& candidate = explanation.candidates.emplace_back();
    candidate.probability = probability;
    Fit& fit = candidate.fit;
    fit.plant = kPendulum;
    fit.effects = std::move(effects);
    const std::vector<Trajectory> paths = smooth_all(kPendulum, data, explanation.noise);
    fit.unknowns = list_unknowns(kPendulum, kPendulum, fit.effects, {}, data, paths);
    const auto count = static_cast<Eigen::Index>(fit.unknowns.size());
    fit.covariance = 1e-6 * Eigen::MatrixXd::Identity(count, count);
  }
  std::optional<NextExperiment> proposed() const { return propose(kPendulum, explanation, data, units); }
};

const Effect kRubbing{CoulombFriction{0.1}, 0, -1}, kGrease{ViscousFriction{0.1}, 0, -1},
    kTilted{ConstantBias{0.1}, 0, -1};

}  // namespace

TEST_CASE("Between two laws of friction an input within the recorded range is proposed, with what it promises",
          "[diagnose][propose]") {
  Doubted doubted;
  doubted.add({kRubbing}, 0.6);
  doubted.add({kGrease, kTilted}, 0.3);
  doubted.add({}, 0.1);
  const std::optional<NextExperiment> next = doubted.proposed();
  REQUIRE(next);
  CHECK(next->separates == std::vector<std::string>{"coulomb_friction", "viscous_friction + constant_bias"});
  CHECK(next->expected_log_odds > 10.0);
  CHECK(next->signal.joint == 1);
  CHECK(next->signal.unit == "V");
  REQUIRE(next->signal.values.size() == 501);  // 10 s,
  CHECK(next->signal.period == Approx(0.02));  // both ends
  const double amplitude = doubted.data[0].input.cwiseAbs().maxCoeff();
  const auto [low, high] = std::minmax_element(next->signal.values.begin(), next->signal.values.end());
  CHECK(std::max(*high, -*low) <= amplitude * (1.0 + 1e-9));
}

TEST_CASE("An input promises half the squares that the other cannot imitate, in units of the noise",
          "[diagnose][propose]") {
  // A free mass that a constant force pushes, or nothing: 0.5 b t^2 / m less the best start and speed, whatever the
  // input. The force, on the other hand, can be adjusted to nothing.
  constexpr double kForce = 0.002, kMass = 2.0, kSensor = 0.01, kProbable = 0.75;
  Measured far{"far", {}, Eigen::VectorXd::LinSpaced(100, 0.0, 1e3), Eigen::MatrixXd::Ones(100, 1), 0.0, false};
  for (int k = 0; k < 100; ++k) far.time.push_back(0.1 * k);
  Explanation explanation;
  explanation.noise = Eigen::VectorXd::Constant(1, kSensor);
  explanation.candidates.resize(2);
  explanation.candidates[0].probability = kProbable;
  explanation.candidates[1].probability = 1.0 - kProbable;
  for (Candidate& candidate : explanation.candidates) candidate.fit.plant = Mass{.mass = kMass, .friction = 0.0};
  Fit& pushed = explanation.candidates[0].fit;
  pushed.effects = {{ConstantBias{kForce}, 0, -1}};
  pushed.unknowns = {{.effect = 0, .name = "torque", .value = kForce}};
  pushed.covariance = Eigen::MatrixXd::Constant(1, 1, 1e-8);
  const std::optional<NextExperiment> next = propose(pushed.plant, explanation, {far}, {{"m", "m/s", "N", "N"}});
  const Eigen::VectorXd t = Eigen::VectorXd::LinSpaced(1001, 0.0, 10.0);
  const Eigen::VectorXd way = 0.5 * kForce / kMass * t.cwiseAbs2();
  Eigen::MatrixXd start(1001, 2);
  start << Eigen::VectorXd::Ones(1001), t;
  const double squares = (way - testing::dense::projected(start, way)).squaredNorm();
  REQUIRE(next);
  CHECK(next->expected_log_odds == Approx(0.5 * kProbable * squares / (kSensor * kSensor)).epsilon(1e-4));
}

TEST_CASE("Half the noise promises four times the log odds, of the same input", "[diagnose][propose]") {
  Doubted doubted;
  doubted.add({kRubbing}, 0.5);
  doubted.add({kGrease}, 0.5);
  const std::optional<NextExperiment> next = doubted.proposed();
  doubted.explanation.noise *= 0.5;
  const std::optional<NextExperiment> quiet = doubted.proposed();
  REQUIRE((next && quiet));
  CHECK(quiet->input == next->input);
  CHECK(quiet->signal.values == next->signal.values);
  CHECK(quiet->expected_log_odds == Approx(4.0 * next->expected_log_odds).epsilon(1e-9));
  std::swap(doubted.explanation.candidates[0], doubted.explanation.candidates[1]);
  const std::optional<NextExperiment> swapped = doubted.proposed();
  REQUIRE(swapped);
  CHECK(swapped->expected_log_odds == Approx(quiet->expected_log_odds).epsilon(1e-9));
  CHECK(swapped->separates == std::vector<std::string>{"viscous_friction", "coulomb_friction"});
}

TEST_CASE("No input is proposed where one explanation stands alone, or where two show the same",
          "[diagnose][propose]") {
  Doubted alone;
  alone.add({kRubbing}, 1.0);
  CHECK(!alone.proposed());
  alone.add({kGrease}, 0.9e-3);
  CHECK(!alone.proposed());
  Doubted same;
  same.add({kGrease}, 0.5);
  same.add({{ViscousFriction{0.05}, 0, -1}}, 0.5);  // once adjusted, the same
  CHECK(!same.proposed());
}
