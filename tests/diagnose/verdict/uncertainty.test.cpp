// By how much a corrected model may still be wrong: closed forms, and draws of the parameters.

#include "diagnose/verdict/uncertainty.hpp"

#include <Eigen/Cholesky>
#include <catch2/catch.hpp>

#include "base/random.hpp"
#include "diagnose/verdict/compared.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

using namespace bayesctrl;

namespace {

/// So many joints that swing for 4 s, never at rest for a sample, under a constant input and a constant missing torque.
struct Oscillation {
  std::vector<Measured> data;
  std::vector<Trajectory> smoothed;
};

Oscillation oscillation(int joints, double input, double missing_torque) {
  constexpr int kSamples = 400;
  Measured m{"swing", {}, Eigen::MatrixXd(kSamples, joints), Eigen::MatrixXd::Constant(kSamples, joints, input)};
  Trajectory path;
  path.velocity.resize(kSamples, joints);
  for (int k = 0; k < kSamples; ++k) {
    m.time.push_back(0.01 * k);
    for (int j = 0; j < joints; ++j) {
      m.position(k, j) = std::sin((1.3 + j) * m.time.back());
      path.velocity(k, j) = (1.3 + j) * std::cos((1.3 + j) * m.time.back());
    }
  }
  path.position = m.position;
  path.missing_torque = Eigen::MatrixXd::Constant(kSamples, joints, missing_torque);
  return {{m}, {path}};
}

Fit fit_with(const Plant& plant, std::vector<Effect> effects, std::vector<Unknown> unknowns,
             const Eigen::MatrixXd& covariance) {
  Fit fit;
  fit.plant = plant;
  fit.effects = std::move(effects);
  fit.unknowns = std::move(unknowns);
  fit.covariance = covariance;
  return fit;
}

/// `left`: of every joint.
ModelUncertainty uncertainty_of(const Fit& fit, const Oscillation& motion, double left) {
  return uncertainty_of({fit.plant, fit.effects, {}}, fit, fit.plant, motion.data, motion.smoothed,
                        Eigen::VectorXd::Constant(motion.data[0].position.cols(), left));
}

}  // namespace

TEST_CASE("What a friction's level leaves open is its deviation over the inertia, and nothing of b", "[diagnose]") {
  const Fit fit = fit_with(Pendulum{.length = 0.7, .mass = 0.5}, {{CoulombFriction{0.4}, 0, -1}}, {{0, "level", 0.4}},
                           Eigen::MatrixXd::Constant(1, 1, 0.02 * 0.02));
  const ModelUncertainty found = uncertainty_of(fit, oscillation(1, 2.0, 0.3), 0.0);
  CHECK(found.drift[0] == Approx(0.02 / (0.5 * 0.7 * 0.7)).epsilon(1e-6));
  CHECK(found.input_gain[0] < 1e-6);
  CHECK(found.coupling.empty());
  CHECK(found.problem(1).empty());
}

TEST_CASE("A tenth of what was missing is left in a, or in b as far as the input shows it", "[diagnose]") {
  const Fit fit = fit_with(Pendulum{.length = 1.0, .mass = 0.5}, {}, {}, Eigen::MatrixXd());
  const ModelUncertainty found = uncertainty_of(fit, oscillation(1, 2.0, 0.3), 0.1);
  CHECK(found.drift[0] == Approx(0.1 * 0.3 / 0.5));
  CHECK(found.input_gain[0] == Approx(0.1 * 0.3 / 2.0));  // of 2 N m of input
  CHECK(uncertainty_of(fit, oscillation(1, 0.0, 0.3), 0.1).input_gain[0] ==
        Approx(1.0));  // no input tells nothing of b
}

TEST_CASE("What an arm's parameters leave open is what draws of them do", "[diagnose]") {
  const Plant arm = TwoLinkArm{};
  Eigen::Matrix3d root;
  root << 0.02, 0.0, 0.0, 0.015, 0.02, 0.0, 0.0, -0.01, 0.05;
  const Fit fit = fit_with(arm, {{AddedInertia{0.2}, 1, -1}, {ViscousFriction{0.3}, 0, -1}},
                           {{-1, "mass2", parameter(arm, "mass2")}, {0, "inertia", 0.2}, {1, "coefficient", 0.3}},
                           root * root.transpose());
  const Oscillation motion = oscillation(2, 1.0, 0.0);
  const ModelUncertainty found = uncertainty_of(fit, motion, 0.0);
  REQUIRE(found.coupling.size() == 2);

  RandomStream random = random_stream(3, "parameters");
  constexpr int kDraws = 400;
  Eigen::Array2d drift = Eigen::Array2d::Zero(), log_gain = drift, coupling = drift;
  for (int draw = 0; draw < kDraws; ++draw) {
    const Eigen::Vector3d change =
        root * Eigen::Vector3d::NullaryExpr([&](Eigen::Index) { return draw_normal(random); });
    Fit moved = fit;
    for (std::size_t i = 0; i < 3; ++i) {
      Unknown unknown = fit.unknowns[i];
      unknown.value += change[static_cast<Eigen::Index>(i)];
      put(moved, unknown);
    }
    for (Eigen::Index k = 0; k < 400; k += 20) {
      const JointVector q = motion.data[0].position.row(k), v = motion.smoothed[0].velocity.row(k);
      const Affine here = affine(Model{fit.plant, fit.effects}, q, v),
                   there = affine({moved.plant, moved.effects}, q, v);
      constexpr double kShare = 1.0 / (kDraws * 20);
      drift += kShare * (there.drift - here.drift).array().square();
      log_gain += kShare * (there.gain.diagonal().array() / here.gain.diagonal().array()).log().square();
      coupling[0] += kShare * std::pow(there.gain(0, 1) - here.gain(0, 1), 2);
      coupling[1] += kShare * std::pow(there.gain(1, 0) - here.gain(1, 0), 2);
    }
  }
  for (std::size_t i = 0; i < 2; ++i) {
    const auto joint = static_cast<Eigen::Index>(i);
    INFO("joint " << i + 1);
    CHECK(found.drift[i] == Approx(std::sqrt(drift[joint])).epsilon(0.1));
    CHECK(found.input_gain[i] == Approx(std::sqrt(log_gain[joint])).epsilon(0.1));
    CHECK(found.coupling[i] == Approx(std::sqrt(coupling[joint])).epsilon(0.1));
  }
}

TEST_CASE("What an arm's motion leaves unexplained is an acceleration of each joint, of the nominal's inertia",
          "[diagnose]") {
  const TwoLinkArm nominal{};
  TwoLinkArm heavier = nominal;
  heavier.mass1 *= 2.0;
  const Fit fit = fit_with(heavier, {}, {}, Eigen::MatrixXd());
  const Oscillation motion = oscillation(2, 1.5, 0.4);
  const ModelUncertainty found =
      uncertainty_of({heavier, {}, {}}, fit, nominal, motion.data, motion.smoothed, Eigen::Vector2d(0.1, 1.0));
  Eigen::Array2d missing = Eigen::Array2d::Zero();
  for (Eigen::Index k = 0; k < 400; ++k) {
    const JointVector q = motion.data[0].position.row(k), v = motion.smoothed[0].velocity.row(k);
    const JointMatrix mobility = bayesctrl::motion(nominal, q, v, JointVector::Zero(2), 0.0).mobility;
    missing += (mobility * JointVector::Constant(2, 0.4)).array().square() / 400.0;
  }
  CHECK(found.drift[0] == Approx(0.1 * std::sqrt(missing[0])));
  CHECK(found.drift[1] == Approx(std::sqrt(missing[1])));
  CHECK(found.coupling[0] == Approx(0.1 * std::sqrt(missing[0]) / 1.5));  // of 1.5 N m of input
}

TEST_CASE("What is left is a share of each joint's error, no less than the noise hides", "[diagnose]") {
  const Compared compared{{}, Eigen::Vector3d(1.0, 0.02, 0.01), Eigen::Vector3d(0.1, 0.03, 0.01), 800.0};
  const Eigen::VectorXd left = compared.left(Eigen::Vector3d::Constant(0.01));
  CHECK(left[0] == Approx(0.1).epsilon(0.01));
  CHECK(left[1] == 1.0);                                              // worse than before
  CHECK(left[2] == Approx(std::sqrt(2.0 * std::sqrt(2.0 / 800.0))));  // within the noise: what that hides
}
