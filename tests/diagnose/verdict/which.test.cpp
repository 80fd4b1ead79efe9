// Which of several sets is stated: laws of the evidence, of equivalents, and of explanations that are left as they are.

#include "diagnose/verdict/which.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>

#include "diagnose/fit/free_runs.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::kPendulumNoise;

namespace {

const Effect kCoulomb{CoulombFriction{0.1}, 0, -1}, kStribeck{StribeckFriction{}, 0, -1},
    kViscous{ViscousFriction{0.1}, 0, -1}, kDrag{QuadraticDrag{0.1}, 0, -1}, kBias{ConstantBias{0.1}, 0, -1};

Candidate candidate_of(std::vector<Effect> effects, double log_evidence, double probability) {
  Candidate candidate;
  candidate.fit.plant = kPendulum;
  candidate.fit.effects = std::move(effects);
  candidate.fit.log_evidence = log_evidence;
  candidate.probability = probability;
  return candidate;
}

Explanation explanation_of(std::vector<Candidate> candidates) {
  Explanation explanation;
  explanation.candidates = std::move(candidates);
  explanation.noise = Eigen::VectorXd::Constant(1, kPendulumNoise);
  return explanation;
}

/// Student's distribution in closed form, for 1, 2 and 4 degrees of freedom: the probability of more than t.
double student_beyond(double t, int degrees) {
  if (degrees == 1) return 0.5 - std::atan(t) / std::numbers::pi;
  if (degrees == 2) return 0.5 - 0.5 * t / std::sqrt(2.0 + t * t);
  const double s = t / std::sqrt(4.0 + t * t);
  return 0.5 - 0.75 * (s - s * s * s / 3.0);
}

Eigen::VectorXd advantages(Eigen::Index rows, RandomStream& random) {
  Eigen::VectorXd more(rows);
  for (double& nats : more) nats = 1.0 + 2.0 * draw_normal(random);
  return more;
}

}  // namespace

TEST_CASE("Bounded evidence is the log odds of Student's test of the rows, where the likelihoods promise more",
          "[diagnose][which]") {
  RandomStream random(1);
  for (const Eigen::Index rows : {2, 3, 5}) {
    for (int round = 0; round < 20; ++round) {
      const Eigen::VectorXd more = advantages(rows, random);
      const double nats = draw_uniform(random, 20.0, 30.0);
      double squares = 0.0;
      for (const double x : more) squares += std::pow(x - more.sum() / static_cast<double>(rows), 2);
      const double deviation = std::sqrt(squares / static_cast<double>(rows - 1) * static_cast<double>(rows));
      const double wrong = student_beyond(nats / deviation, static_cast<int>(rows) - 1);
      CAPTURE(rows, more.transpose(), nats);
      CHECK(vuong_bounded(nats, more) == Approx(std::min(nats, std::log((1.0 - wrong) / wrong))).epsilon(1e-6));
    }
  }
}

TEST_CASE("Bounded evidence never exceeds that of the likelihoods, nor depends on the order of the rows",
          "[diagnose][which]") {
  RandomStream random(2);
  for (int round = 0; round < 50; ++round) {
    const Eigen::VectorXd more = advantages(12, random);
    const double nats = draw_uniform(random, 0.0, 40.0), bounded = vuong_bounded(nats, more);
    CHECK(bounded <= nats);
    CHECK(bounded >= 0.0);
    CHECK(vuong_bounded(nats, more.reverse()) == Approx(bounded).epsilon(1e-9));
    CHECK(vuong_bounded(nats, (more.array() + 5.0).matrix()) == Approx(bounded).epsilon(1e-9));
    CHECK(vuong_bounded(nats, 3.0 * more) <= bounded);
  }
}

TEST_CASE("Effects that replace one another in the best set with hardly any loss are equivalent, and count as one",
          "[diagnose][which]") {
  const Explanation explanation = explanation_of({
      candidate_of({kCoulomb, kDrag}, 100.0, 0.50),
      candidate_of({kDrag, kStribeck}, 98.0, 0.20),   // in another order
      candidate_of({kCoulomb, kViscous}, 97.5, 0.1),  // for the drag
      candidate_of({kStribeck, kViscous}, 90.0, 0.08),
      candidate_of({kCoulomb, kBias}, 96.9, 0.05),  // 3.1 nats behind
      candidate_of({kBias, kViscous}, 99.0, 0.04),  // both differ
      candidate_of({kCoulomb}, 99.0, 0.02),
      candidate_of({kCoulomb, kDrag, kBias}, 99.0, 0.006),
      candidate_of({}, 0.0, 0.004),
  });
  const Equivalence equivalence = find_equivalent(explanation, 1);
  REQUIRE(equivalence.classes.size() == 2);
  CHECK(equivalence.classes[0] == std::vector<std::string>{"coulomb_friction", "stribeck_friction"});
  CHECK(equivalence.classes[1] == std::vector<std::string>{"quadratic_drag", "viscous_friction"});
  CHECK(equivalence.probability == Approx(0.5 + 0.2 + 0.1 + 0.08));  // one of each class
  REQUIRE(equivalence.sets.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(equivalence.sets[i] == &explanation.candidates[i]);
}

TEST_CASE("The same effect in another joint or with much more evidence is no equivalent", "[diagnose][which]") {
  Effect elbow = kCoulomb;
  elbow.joint = 1;
  const Explanation explanation = explanation_of(
      {candidate_of({kCoulomb}, 50.0, 0.6), candidate_of({elbow}, 40.0, 0.3), candidate_of({kBias}, 54.0, 0.1)});
  const Equivalence equivalence = find_equivalent(explanation, 2);
  CHECK(equivalence.classes == std::vector<std::vector<std::string>>{{"coulomb_friction@1"}});
  CHECK(equivalence.probability == Approx(0.6));
  CHECK(labels({kCoulomb, elbow}, 2) == std::vector<std::string>{"coulomb_friction@1", "coulomb_friction@2"});
  CHECK(labels({kBias, kCoulomb}, 1) == std::vector<std::string>{"constant_bias", "coulomb_friction"});
}

TEST_CASE("Where nothing is missing the empty set stands for itself alone", "[diagnose][which]") {
  const Equivalence equivalence =
      find_equivalent(explanation_of({candidate_of({}, 10.0, 0.7), candidate_of({kBias}, 9.0, 0.3)}), 1);
  CHECK(equivalence.classes.empty());
  CHECK(equivalence.probability == Approx(0.7));
  CHECK(equivalence.sets.size() == 1);
}

TEST_CASE("The strongest effect is the one without which most evidence is lost, wherever it stands in the set",
          "[diagnose][which]") {
  const auto by_name = [](const Effect& a, const Effect& b) { return label(a, 1) < label(b, 1); };
  std::vector<Effect> set{kBias, kCoulomb, kDrag};
  REQUIRE(std::is_sorted(set.begin(), set.end(), by_name));
  do {
    const Explanation explanation =
        explanation_of({candidate_of(set, 100.0, 0.9), candidate_of({kCoulomb, kBias}, 70.0, 0.0),
                        candidate_of({kDrag, kBias}, 40.0, 0.0), candidate_of({kCoulomb, kDrag}, 99.0, 0.0),
                        candidate_of({kViscous}, -500.0, 0.0), candidate_of({}, 0.0, 0.0)});
    CHECK(label(set[strongest(explanation)], 1) == "coulomb_friction");
  } while (std::next_permutation(set.begin(), set.end(), by_name));
}

TEST_CASE("The error beyond the noise and the noise make the error of free runs, at right angles",
          "[diagnose][which]") {
  const std::vector<Measured> data{testing::record(Machine(kPendulum, {kDrag}), -1.0, 5)};
  Explanation explanation = explanation_of({candidate_of({}, 0.0, 1.0)});
  const std::vector<Trajectory> paths = smooth_all(kPendulum, data, explanation.noise);
  const Fit& nominal = explanation.best().fit;
  const double rms = free_runs({kPendulum, {}, {}}, data, paths, 1.0, false, explanation.max_step).rms;
  for (const double part : {0.1, 0.6, 0.99}) {
    explanation.noise[0] = part * rms;
    CHECK(error_beyond_noise(nominal, explanation, data, paths, 1.0) ==
          Approx(rms * std::sqrt(1.0 - part * part)).epsilon(1e-9));
  }
  explanation.noise[0] = 1.01 * rms;
  CHECK(error_beyond_noise(nominal, explanation, data, paths, 1.0) == 0.0);
}

TEST_CASE("An explanation that leaves little more than noise, or that has no effect, stays as it is",
          "[diagnose][which]") {
  const bool has_effect = GENERATE(true, false);
  Explanation explanation = explanation_of({candidate_of({kCoulomb}, 9.0, 0.7), candidate_of({}, 1.0, 0.3)});
  if (!has_effect) std::swap(explanation.candidates[0], explanation.candidates[1]);
  explanation.rows = 400.0;
  for (Candidate& candidate : explanation.candidates) candidate.fit.sse = (has_effect ? 4.9 : 40.0) * 400.0;
  REQUIRE((explanation.excess(explanation.best().fit) < 2.0) == has_effect);
  const std::string before = key(explanation.best().fit.effects);
  prefer_simple(explanation, {}, {}, 1.0);
  CHECK(key(explanation.best().fit.effects) == before);
  CHECK(explanation.candidates[0].probability == (has_effect ? 0.7 : 0.3));
  CHECK(explanation.candidates[1].probability == (has_effect ? 0.3 : 0.7));
}
