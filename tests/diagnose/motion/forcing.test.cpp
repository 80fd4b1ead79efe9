// What effects do along a motion that is known in closed form: means over each step against fine quadrature.

#include "diagnose/motion/forcing.hpp"

#include <catch2/catch.hpp>

#include "diagnose/motion/operating_range.hpp"
#include "physics/catalogue.hpp"
#include "physics/effect_law.hpp"
#include "physics/parameters.hpp"
#include "support/compare.hpp"
#include "support/families.hpp"
#include "support/linearised.hpp"

using namespace bayesctrl;
using testing::largest_difference;

namespace {

constexpr double kPeriod = 0.01, kSpeedDeviation = 0.03;

/// Two joints that swing, and what each recording of them begins with.
JointVector swing(double t, double phase) {
  return JointVector{{0.9 * std::sin(2.3 * t + phase) + 0.2, 0.7 * std::cos(3.1 * t - phase) - 0.4}};
}
JointVector swing_rate(double t, double phase) {
  return JointVector{{0.9 * 2.3 * std::cos(2.3 * t + phase), -0.7 * 3.1 * std::sin(3.1 * t - phase)}};
}

/// Two recordings of the same motion, begun at different phases; of one joint the first.
struct Swings {
  explicit Swings(const Plant& machine) : plant(machine), joints(bayesctrl::joints(machine)) {
    for (const Eigen::Index samples : {400, 250}) {
      const double phase = static_cast<double>(data.size());
      Measured& m = data.emplace_back();
      Trajectory& path = paths.emplace_back();
      m.input.resize(samples, joints);
      path.position = path.velocity = Eigen::MatrixXd(samples, joints);
      for (Eigen::Index k = 0; k < samples; ++k) {
        const double t = kPeriod * static_cast<double>(k);
        m.time.push_back(t);
        path.position.row(k) = swing(t, phase).head(joints).transpose();
        path.velocity.row(k) = swing_rate(t, phase).head(joints).transpose();
        for (int j = 0; j < joints; ++j) m.input(k, j) = 2.0 * std::sin(1.7 * t + j) + std::cos(5.3 * t);
      }
      m.position = path.position;
      m.temperature = testing::warming();
      path.velocity_sd = Eigen::MatrixXd::Constant(samples, joints, kSpeedDeviation);
    }
  }
  Swings(const Swings&) = delete;  // the forcing refers to the rest

  Plant plant;
  int joints;
  std::vector<Measured> data;
  std::vector<Trajectory> paths;

  Forcing forcing() const { return {plant, data, paths}; }

  /// State of a joint at a time, with the input held since sample k.
  JointState seen(std::size_t r, int j, std::size_t k, double t) const {
    const JointVector q = swing(t, static_cast<double>(r)).head(joints);
    const JointVector v = swing_rate(t, static_cast<double>(r)).head(joints);
    return {q[j],
            v[j],
            t,
            data[r].input(static_cast<Eigen::Index>(k), j),
            external_torque(plant, q)[j],
            q[joints - 1 - j],
            0.0,
            data[r].temperature->at(j, t)};
  }

  /// Mean over each step of what a torque in one joint accelerates, from `kFine` points within it.
  Eigen::MatrixXd mean(std::size_t r, int j, auto&& torque) const {
    constexpr int kFine = 40;
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(data[r].position.rows(), joints);
    for (std::size_t k = 0; k + 1 < data[r].samples(); ++k) {
      for (int i = 0; i < kFine; ++i) {
        const double t = data[r].time[k] + kPeriod * (i + 0.5) / kFine;
        const JointVector q = swing(t, static_cast<double>(r)).head(joints), none = JointVector::Zero(joints);
        const JointVector by = motion(plant, q, none, none, 0.0).mobility.col(j) * torque(seen(r, j, k, t));
        result.row(static_cast<Eigen::Index>(k)) += by.transpose() / kFine;
      }
    }
    return result;
  }
};

double relative(const Eigen::MatrixXd& found, const Eigen::MatrixXd& expected) {
  return (found - expected).norm() / expected.norm();
}

const Plant kArm = TwoLinkArm{.mass1 = 1.2, .mass2 = 0.7, .length1 = 0.6, .com2 = 0.4};

/// An example of each type of effect, strong enough to act along the swings.
template <class E>
E example(const Swings& swings, int joint) {
  const auto shapes = E::shapes(operating_range(swings.data, swings.paths, joint));
  const auto& shape = shapes[shapes.size() / 2];
  const std::vector<double> ones(shape.members.size(), 1.0);
  return E::combined(shape, ones);
}

}  // namespace

TEST_CASE("What acts in one recording does nothing in another, alone or in a set", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  for (const std::size_t r : {std::size_t{0}, std::size_t{1}}) {
    const int there = static_cast<int>(r), elsewhere = 1 - there;
    CHECK(forcing.measured({RecordingOffset{{0.2}}, 1, elsewhere}, r).isZero(0.0));
    CHECK(forcing.measured({RecordingOffset{{0.2}}, 1, there}, r).col(1).isApproxToConstant(0.2, 1e-12));
    const std::vector<Effect> gain{{RecordingGain{{0.7}}, 0, there}, {RecordingGain{{3.0}}, 0, elsewhere}};
    CHECK(forcing.acceleration(gain, r) == forcing.acceleration(Effect{InputGain{0.7}, 0}, r));
    CHECK(forcing.acceleration(gain[1], r).isZero(0.0));
  }
}

TEST_CASE("A torque of any form accelerates by its mean over each step", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  const auto normal_cdf = [](double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); };
  int checked = 0;
  for_each_effect([&]<class E>(const E&) {
    for (const int j : {0, 1}) {
      const E form = example<E>(swings, j);
      CAPTURE(E::kName, j);
      for (const std::size_t r : {std::size_t{0}, std::size_t{1}}) {
        const Eigen::MatrixXd found = forcing.acceleration(Effect{form, j}, r);
        CHECK(found.bottomRows(1).isZero());  // the last sample begins no step
        if constexpr (TorqueEffect<E>) {
          const Eigen::MatrixXd expected = swings.mean(r, j, [&](const JointState& s) { return form.torque_at(s); });
          if (expected.isZero()) continue;  // it acts in the other recording
          CHECK(relative(found, expected) < (std::is_same_v<E, HardStop> ? 0.03 : 0.005));
          ++checked;
        } else if constexpr (DryFriction<E>) {
          const Eigen::MatrixXd expected = swings.mean(r, j, [&](const JointState& s) {
            return form.sliding(s) * (1.0 - 2.0 * normal_cdf(s.velocity / kSpeedDeviation));
          });
          CHECK(relative(found, expected) < 0.005);
          ++checked;
        }
      }
    }
  });
  CHECK(checked > 40);
}

TEST_CASE("Effects with a hidden state accelerate as that state follows the motion", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  for_each_effect([&]<class E>(const E&) {
    if constexpr (HiddenStateEffect<E>) {
      for (const int j : {0, 1}) {
        const E form = example<E>(swings, j);
        CAPTURE(E::kName, j);
        typename E::State z{};
        double before = 0.0;
        const Eigen::MatrixXd expected = swings.mean(0, j, [&](const JointState& s) {  // in the order of time
          const double h = s.time - before;
          z = moved(z, form.rate(moved(z, form.rate(z, s), 0.5 * h), s), h);
          before = s.time;
          return form.torque_of(z, s);
        });
        CHECK(relative(forcing.acceleration(Effect{form, j}, 0), expected) < 0.003);
      }
    }
  });
}

TEST_CASE("An inertia resists the motion's mean acceleration, a tilt turns gravity", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  for (const int j : {0, 1}) {
    const Eigen::MatrixXd inertia = swings.mean(0, j, [&](const JointState& s) {
      constexpr double kStep = 1e-4;
      return -0.07 * (swing_rate(s.time + kStep, 0.0)[j] - swing_rate(s.time - kStep, 0.0)[j]) / (2.0 * kStep);
    });
    CHECK(relative(forcing.acceleration(Effect{AddedInertia{0.07}, j}, 0), inertia) < 1e-3);
    // Both joints feel how gravity turns: each of the two torques by itself.
    Eigen::MatrixXd tilted = Eigen::MatrixXd::Zero(inertia.rows(), 2);
    for (const int felt : {0, 1}) {
      tilted += swings.mean(0, felt, [&](const JointState& s) {
        JointVector q = swing(s.time, 0.0);
        const double upright = external_torque(kArm, q)[felt];
        q[j] += 0.2;
        return external_torque(kArm, q)[felt] - upright;
      });
    }
    CHECK(relative(forcing.acceleration(Effect{GravityTilt{0.2}, j}, 0), tilted) < 1e-3);
  }
}

TEST_CASE("In total an inertia divides what moves its joint, whatever the motion does", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  const std::vector<Effect> others{{CoulombFriction{0.4}, 0}, {QuadraticDrag{0.2}, 1}};
  const Eigen::MatrixXd nominal = forcing.total(kArm, {}, 0), light = forcing.total(kArm, others, 0);
  CHECK(largest_difference(light - nominal, forcing.acceleration(others, 0)) < 1e-12);
  for (const int j : {0, 1}) {
    std::vector<Effect> set = others;
    set.push_back({AddedInertia{0.07}, j});
    const Eigen::MatrixXd heavy = forcing.total(kArm, set, 0);
    for (Eigen::Index k = 0; k + 1 < heavy.rows(); ++k) {
      const JointVector q = 0.5 * (forcing.paths()[0].position.row(k) + forcing.paths()[0].position.row(k + 1));
      const JointMatrix mobility = motion(kArm, q, JointVector::Zero(2), JointVector::Zero(2), 0.0).mobility;
      JointVector torque = inverse_dynamics<Eigen::Dynamic>(mobility, JointVector(heavy.row(k).transpose()));
      torque[j] += 0.07 * heavy(k, j);
      const JointVector wanted = inverse_dynamics<Eigen::Dynamic>(mobility, JointVector(light.row(k).transpose()));
      REQUIRE((torque - wanted).norm() < 1e-3 * (1.0 + wanted.norm()));
    }
  }
}

TEST_CASE("In total dry friction holds what rests, as far as it can", "[diagnose][motion]") {
  const Plant plant = Mass{.mass = 2.0};
  Measured still{"still", {},   Eigen::MatrixXd::Constant(200, 1, 0.1), Eigen::MatrixXd::Constant(200, 1, 0.3),
                 0.0,     false};
  for (int k = 0; k < 200; ++k) still.time.push_back(0.01 * k);
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(200, 1);
  const std::vector<Measured> data{still};
  const std::vector<Trajectory> paths{{still.position, zero, Eigen::MatrixXd::Constant(200, 1, 1e-3), zero, zero}};
  const Forcing forcing(plant, data, paths);
  const auto total = [&](const std::vector<Effect>& set) { return forcing.total(plant, set, 0)(100, 0); };
  CHECK(total({}) == Approx(0.15));
  CHECK(total({{CoulombFriction{0.4}, 0}}) == Approx(0.0).margin(1e-12));
  CHECK(total({{CoulombFriction{0.1}, 0}}) == Approx(0.1));
  CHECK(total({{CoulombFriction{0.1}, 0}, {AddedInertia{2.0}, 0}}) == Approx(0.05));
  CHECK(total({{CoulombFriction{0.1}, 0}, {ConstantBias{-0.5}, 0}}) == Approx(-0.05));
  CHECK(total({{ViscousFriction{4.0}, 0}}) == Approx(0.15));
}

TEST_CASE("Effects on the input act one after the other, by what they change of it", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  for (const int j : {0, 1}) {
    const auto changed = [&](auto&& input) {  // of sample k
      return swings.mean(1, j, [&](const JointState& s) {
        return input(static_cast<std::size_t>(s.time / kPeriod)) - s.motor_torque;
      });
    };
    const auto u = [&](std::size_t k) { return swings.data[1].input(static_cast<Eigen::Index>(k), j); };
    const auto of = [&](std::initializer_list<EffectForm> forms) {
      std::vector<Effect> set;
      for (const EffectForm& form : forms) set.push_back({form, j});
      return forcing.acceleration(set, 1);
    };
    const auto gained = [&](std::size_t k) { return 1.3 * u(k); };
    CHECK(relative(of({InputGain{1.3}}), changed(gained)) < 1e-3);
    const auto limited = [&](std::size_t k) { return std::clamp(1.3 * u(k), -1.2, 1.2); };
    CHECK(relative(of({InputSaturation{1.2}, InputGain{1.3}}), changed(limited)) < 1e-3);
    // Late by a step and a quarter: the mean of what is held by then.
    const auto late = [&](std::size_t k) { return 0.75 * (k > 0 ? u(k - 1) : 0.0) + 0.25 * (k > 1 ? u(k - 2) : 0.0); };
    CHECK(relative(of({InputDelay{1.25 * kPeriod}}), changed(late)) < 1e-3);
    // A lag, which has settled on the first input.
    constexpr double kLag = 0.05;
    std::vector<double> mean;
    for (double y = u(0); mean.size() < swings.data[1].samples();) {
      const double target = u(mean.size()), left = std::exp(-kPeriod / kLag);
      mean.push_back(target + (y - target) * (1.0 - left) * kLag / kPeriod);
      y = target + (y - target) * left;
    }
    CHECK(relative(of({ActuatorLag{kLag}}), changed([&](std::size_t k) { return mean[k]; })) < 2e-3);
  }
}

TEST_CASE("What a model adds to the nominal is a torque of its joints", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  CHECK(forcing.torque(kArm, {}, 0).isZero());
  const Effect bias{ConstantBias{0.3}, 0}, coulomb{CoulombFriction{0.4}, 1};
  const Eigen::MatrixXd torque = forcing.torque(kArm, {bias, coulomb}, 0);
  REQUIRE(torque.rows() == forcing.data()[0].position.rows());
  CHECK(largest_difference(torque.col(0), Eigen::VectorXd::Constant(torque.rows(), 0.3)) < 1e-4);
  CHECK(torque.col(1).cwiseAbs().maxCoeff() < 0.4 + 1e-3);
  const auto& v = forcing.paths()[0].velocity;
  for (Eigen::Index k = 0; k + 1 < torque.rows(); ++k) {
    if (v(k, 1) * v(k + 1, 1) > 0.01) CHECK(torque(k, 1) == Approx(v(k, 1) > 0.0 ? -0.4 : 0.4).epsilon(1e-3));
  }
  Plant heavier = kArm;
  set_parameter(heavier, "inertia2", 1.5 * parameter(kArm, "inertia2"));
  CHECK(forcing.torque(heavier, {}, 0).col(1).norm() > 0.0);
}

TEST_CASE("Torques of a set add up, and what rubs under load feels the springs beside it", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  const Effect coulomb{CoulombFriction{0.4}, 0}, drag{QuadraticDrag{0.2}, 1}, spring{LinearSpring{2.0}, 1};
  const Effect rubs{LoadDependentFriction{.k = 0.1}, 1};
  const auto alone = [&](const Effect& effect) { return forcing.acceleration(effect, 0); };
  CHECK(largest_difference(forcing.acceleration({coulomb, drag}, 0), alone(coulomb) + alone(drag)) < 1e-12);
  const Eigen::MatrixXd loaded = forcing.acceleration(rubs, 0, {spring});
  CHECK(largest_difference(forcing.acceleration({rubs, spring}, 0), loaded + alone(spring)) < 1e-12);
  CHECK(largest_difference(loaded, alone(rubs)) > 0.1);
}

TEST_CASE("A sensor accelerates nothing and shows another position, all else shows the true one",
          "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  for_each_effect([&]<class E>(const E&) {
    CAPTURE(E::kName);
    const Effect effect{example<E>(swings, 1), 1};
    const Eigen::MatrixXd shown = forcing.measured(effect, 0);
    CHECK(shown.col(0).isZero());
    if constexpr (SensorEffect<E>) {
      CHECK(forcing.acceleration(effect, 0).isZero());
      for (Eigen::Index k = 0; k < shown.rows(); ++k) {
        const double q = swings.paths[0].position(k, 1);
        CHECK(q + shown(k, 1) == Approx(effect.form.get<E>().measured(q)));
      }
    } else {
      CHECK(shown.isZero());
    }
  });
}

TEST_CASE("A pendulum that is written down is accelerated as the pendulum", "[diagnose][motion]") {
  const Pendulum pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};
  const Swings swings(pendulum), written(testing::written_pendulum(pendulum));
  const Forcing of_pendulum = swings.forcing(), of_written = written.forcing();
  for_each_effect([&]<class E>(const E&) {
    const auto shapes = E::shapes(operating_range(swings.data, swings.paths, 0));
    if (shapes.empty()) return;  // it needs a second joint
    CAPTURE(E::kName);
    const Effect effect{example<E>(swings, 0), 0};
    CHECK(largest_difference(of_pendulum.acceleration(effect, 0), of_written.acceleration(effect, 0)) < 1e-9);
    CHECK(largest_difference(of_pendulum.acceleration(std::vector{effect}, 0),
                             of_written.acceleration(std::vector{effect}, 0)) < 1e-9);
  });
  CHECK(of_pendulum.nominal_acceleration() == Approx(of_written.nominal_acceleration()));
}

TEST_CASE("More of a parameter accelerates as the effect that adds it", "[diagnose][motion]") {
  const Pendulum pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};
  const Swings swings(pendulum);
  const Forcing forcing = swings.forcing();
  Pendulum other = pendulum;
  other.friction += 0.15;
  CHECK(largest_difference(forcing.acceleration(Plant{other}, 1),
                           forcing.acceleration(Effect{ViscousFriction{0.15}, 0}, 1)) < 1e-12);
  CHECK(forcing.acceleration(Plant{pendulum}, 1).isZero());  // nothing differs, nothing is added
}

TEST_CASE("An effect in one recording does nothing in the others", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  CHECK(forcing.acceleration(Effect{ConstantBias{0.5}, 0, 0}, 1).isZero());
  CHECK(largest_difference(forcing.acceleration(Effect{ConstantBias{0.5}, 0, 1}, 1),
                           forcing.acceleration(Effect{ConstantBias{0.5}, 0}, 1)) == 0.0);
}

TEST_CASE("A torque given for each step acts through the inertia in its midst", "[diagnose][motion]") {
  const Swings swings(kArm);
  const Forcing forcing = swings.forcing();
  const Eigen::VectorXd torque = Eigen::VectorXd::LinSpaced(400, -1.0, 2.0);
  const Eigen::MatrixXd expected =
      swings.mean(0, 1, [&](const JointState& s) { return torque[static_cast<Eigen::Index>(s.time / kPeriod)]; });
  CHECK(relative(forcing.acceleration(torque, 1, 0), expected) < 1e-3);
}

TEST_CASE("The nominal's acceleration is that of its torques' scale, and the range that of the motion",
          "[diagnose][motion]") {
  const Swings swings(Mass{.mass = 3.0, .friction = 0.4});
  const double torque = torque_scale(swings.plant, swings.data)[0];
  CHECK(swings.forcing().nominal_acceleration() == Approx(torque / 3.0 * std::sqrt(648.0 / 650.0)));
  const OperatingRange range = operating_range(swings.data, swings.paths, 0);
  CHECK(range.lowest == Approx(0.2 - 0.9).margin(1e-3));
  CHECK(range.highest == Approx(0.2 + 0.9).margin(1e-3));
  CHECK(range.speed == Approx(0.9 * 2.3).margin(1e-3));
  CHECK(range.input == swings.data[0].input.cwiseAbs().maxCoeff());
  CHECK(range.period == Approx(kPeriod));
  CHECK(range.durations == std::vector{swings.data[0].time.back(), swings.data[1].time.back()});
  CHECK(range.joints == 1);
}
