// The Jacobian of the linear response against closed forms and, for faint effects, against the exact one; priors that
// follow from what a parameter does.

#include "diagnose/fit/linear_jacobian.hpp"

#include <catch2/catch.hpp>
#include <functional>

#include "diagnose/fit/exact_jacobian.hpp"
#include "physics/catalogue.hpp"
#include "support/linearised.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::Linearised, testing::recorded;

namespace {

constexpr double kMass = 1.6;

/// A slide without friction: what acts on it is integrated twice.
const Linearised& slide() {
  static const Plant plant = Mass{kMass, 0.0};
  static const Linearised about(
      plant, {recorded(Machine(plant, {}), {.seconds = 4.0}), recorded(Machine(plant, {}), {.seconds = 2.0})}, 1e-3);
  return about;
}

/// Rows of positions that a force gives the slide from rest at the beginning of each window.
Eigen::VectorXd rows_of_force(const std::function<double(std::size_t recording, Eigen::Index sample)>& force) {
  const Linearised& about = slide();
  Eigen::VectorXd rows(about.response.rows());
  for (std::size_t w = 0; w < about.response.windows().size(); ++w) {
    const Segment& window = about.response.windows()[w];
    Eigen::MatrixXd position(static_cast<Eigen::Index>(window.samples()), 1);
    double q = 0.0, v = 0.0;
    for (Eigen::Index i = 0; i < position.rows(); ++i) {
      position(i, 0) = q;
      const double a = force(window.recording, static_cast<Eigen::Index>(window.first) + i) / kMass, h = 0.01;
      q += h * v + 0.5 * h * h * a;
      v += h * a;
    }
    rows.segment(about.response.first_row(w), about.response.row_count(w)) = about.response.project(w, position);
  }
  return rows;
}

/// The column of one parameter of an effect.
Eigen::VectorXd column(const Linearised& about, const Fit& fit, std::string_view name) {
  const Eigen::MatrixXd jacobian = linear_jacobian(about.problem, fit);
  REQUIRE(jacobian.cols() == static_cast<Eigen::Index>(fit.unknowns.size()));
  for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
    if (fit.unknowns[i].name == name) return jacobian.col(static_cast<Eigen::Index>(i));
  }
  throw std::invalid_argument("no such parameter");
}

/// Of its prior, the least where that follows the value.
double deviation_of(const Linearised& about, Fit fit, std::string_view name) {
  complete_priors(about.problem, fit);
  for (const Unknown& unknown : fit.unknowns) {
    if (unknown.name == name) return unknown.least_deviation > 0.0 ? unknown.least_deviation : unknown.prior_deviation;
  }
  throw std::invalid_argument("no such parameter");
}

/// Of what does nothing but for moments, at an edge, near rest or where a spring rings, where the linear response is
/// coarse.
bool is_momentary(std::string_view effect, std::string_view parameter) {
  return (effect == "hard_stop" && parameter == "position") ||
         (effect == "stribeck_friction" && parameter != "coulomb") ||
         (effect == "load_stribeck_friction" && parameter != "k") ||
         (effect == "elastic_load" && parameter != "inertia") ||
         (effect == "joint_elasticity" && parameter == "damping");
}

}  // namespace

TEST_CASE("On a slide the columns of effects are the double integrals of what they do, in their own recording",
          "[diagnose][fit]") {
  const Linearised& about = slide();
  const auto check = [&](const EffectForm& form, std::string_view name, int recording, auto&& force) {
    const Fit fit = about.at_truth({{form, 0, recording}});
    const Eigen::VectorXd expected = rows_of_force([&](std::size_t r, Eigen::Index k) {
      return recording < 0 || static_cast<std::size_t>(recording) == r ? force(r, k) : 0.0;
    });
    INFO(name_of(form) << " " << name);
    REQUIRE(expected.norm() > 0.0);
    CHECK((column(about, fit, name) - expected).norm() < 2e-3 * expected.norm());
  };
  const auto input = [&](std::size_t r, Eigen::Index k) { return about.data[r].input(k, 0); };
  const auto speed = [&](std::size_t r, Eigen::Index k) {
    return 0.5 * (about.paths[r].velocity(k, 0) +
                  about.paths[r].velocity(std::min(k + 1, about.paths[r].velocity.rows() - 1), 0));
  };
  const auto place = [&](std::size_t r, Eigen::Index k) {
    return 0.5 * (about.paths[r].position(k, 0) +
                  about.paths[r].position(std::min(k + 1, about.paths[r].position.rows() - 1), 0));
  };
  for (const int recording : {-1, 0, 1}) {
    CAPTURE(recording);
    check(ConstantBias{0.1}, "torque", recording, [](auto, auto) { return 1.0; });
    check(InputGain{1.1}, "gain", recording, input);
    check(ViscousFriction{0.1}, "coefficient", recording, [&](auto r, auto k) { return -speed(r, k); });
    check(LinearSpring{0.1}, "stiffness", recording, [&](auto r, auto k) { return -place(r, k); });
    check(QuadraticDrag{0.1}, "coefficient", recording,
          [&](auto r, auto k) { return -speed(r, k) * std::abs(speed(r, k)); });
    check(PeriodicDisturbance{0.5, 6.0, 0.3}, "amplitude", recording,
          [](auto, auto k) { return std::sin(6.0 * 0.01 * (static_cast<double>(k) + 0.5) + 0.3); });
    check(PeriodicDisturbance{0.5, 6.0, 0.3}, "phase", recording,
          [](auto, auto k) { return 0.5 * std::cos(6.0 * 0.01 * (static_cast<double>(k) + 0.5) + 0.3); });
    check(TorqueStep{0.5, 0.7}, "torque", recording, [](auto, auto k) { return k >= 70 ? 1.0 : 0.0; });
  }
}

TEST_CASE("A free mass moves a slide by what its motion takes of force", "[diagnose][fit]") {
  const Plant plant = Mass{kMass, 0.0};
  Linearised about(
      plant, {recorded(Machine(plant, {}), {.seconds = 4.0}), recorded(Machine(plant, {}), {.seconds = 2.0})}, 1e-3);
  about.problem.free = {"mass"};
  const Eigen::VectorXd expected =
      rows_of_force([&](std::size_t r, Eigen::Index k) { return -about.data[r].input(k, 0) / kMass; });
  CHECK((column(about, about.at_truth({}), "mass") - expected).norm() < 1e-4 * expected.norm());
}

TEST_CASE("What the sensor shows otherwise is what initial states cannot hide", "[diagnose][fit]") {
  const Linearised& about = slide();
  const Eigen::VectorXd offset = column(about, about.at_truth({{SensorOffset{0.1}, 0, -1}}), "angle");
  CHECK(offset.norm() < 1e-6);  // a slide that stands elsewhere
  const Eigen::VectorXd scale = column(about, about.at_truth({{SensorScale{1.1}, 0, -1}}), "scale");
  Eigen::VectorXd expected(about.response.rows());
  for (std::size_t w = 0; w < about.response.windows().size(); ++w) {
    const Segment& window = about.response.windows()[w];
    const auto first = static_cast<Eigen::Index>(window.first), size = static_cast<Eigen::Index>(window.samples());
    expected.segment(about.response.first_row(w), about.response.row_count(w)) =
        about.response.project(w, about.paths[window.recording].position.middleRows(first, size));
  }
  CHECK((scale - expected).norm() < 1e-6 * expected.norm());
}

TEST_CASE("For every faint effect in an arm the linear response gives nearly the exact Jacobian", "[diagnose][fit]") {
  for_each_effect([&]<class E>(const E&) {
    const std::vector<Effect> effects{{testing::drawn_effect<E>(0.02), 1, -1}};
    const Linearised about(TwoLinkArm{},
                           {recorded(Machine(TwoLinkArm{}, effects, {}, testing::warming()), {.seconds = 4.0})}, 1e-3);
    const Fit fit = about.at_truth(effects);
    Eigen::MatrixXd linear = linear_jacobian(about.problem, fit);
    Eigen::MatrixXd exact = ExactJacobian(about.problem, fit, linear).jacobian();
    // Where a hidden state is not known it does part of the work, of which the linear response knows nothing.
    if (effects[0].form.roles().hidden_state) {
      const Eigen::Index opening = about.response.row_count(0);
      linear.topRows(opening).setZero();
      exact.topRows(opening).setZero();
    }
    for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
      const auto slot = static_cast<Eigen::Index>(i);
      INFO(E::kName << " " << fit.unknowns[i].name);
      const double off = (linear.col(slot) - exact.col(slot)).norm();
      if (is_momentary(E::kName, fit.unknowns[i].name)) {
        CHECK(linear.col(slot).dot(exact.col(slot)) > 0.0);
      } else {
        CHECK(off < 0.08 * exact.col(slot).norm());
      }
    }
  });
}

TEST_CASE("At a bound differences are taken on the side that is admitted", "[diagnose][fit]") {
  const Plant plant = Custom({{{"d", 0.4}}}, {"u - 4*sin(q) - d*v + exp(1e12*(abs(d-0.4)+d-0.4)) - 1"}, {});
  Linearised about(plant, {recorded(Machine(plant, {}), {.seconds = 4.0})}, 1e-3);
  about.problem.free = {"d"};
  Fit fit = about.at_truth({});
  fit.unknowns[0].high = 0.4;
  const Eigen::VectorXd at_bound = column(about, fit, "d");
  assign(fit, Eigen::VectorXd::Constant(1, 0.3));
  const Eigen::VectorXd within = column(about, fit, "d");
  CHECK((at_bound - within).norm() < 1e-6 * within.norm());
}

TEST_CASE("A model without unknowns has a Jacobian without columns", "[diagnose][fit]") {
  const Eigen::MatrixXd none = linear_jacobian(slide().problem, slide().at_truth({}));
  CHECK(none.rows() == slide().response.rows());
  CHECK(none.cols() == 0);
}

TEST_CASE("A prior that no effect declares is that at which the parameter accelerates by a fifth of the nominal",
          "[diagnose][fit]") {
  const Linearised& about = slide();
  const auto rms = [&](auto&& force) {
    double squares = 0.0, samples = 0.0;
    for (std::size_t r = 0; r < about.data.size(); ++r) {
      for (Eigen::Index k = 0; k + 1 < about.data[r].input.rows(); ++k) squares += std::pow(force(r, k), 2);
      samples += static_cast<double>(about.data[r].samples());
    }
    return std::sqrt(squares / samples);
  };
  const double allowed = 0.2 * about.forcing.nominal_acceleration() * kMass;
  const auto of = [&](const EffectForm& form, std::string_view name, int recording = -1) {
    return deviation_of(about, about.at_truth({{form, 0, recording}}), name);
  };
  CHECK(of(ConstantBias{0.1}, "torque") == Approx(allowed / rms([](auto, auto) { return 1.0; })));
  CHECK(of(ConstantBias{7.0}, "torque") == Approx(of(ConstantBias{0.1}, "torque")));
  CHECK(of(InputGain{1.3}, "gain") ==
        Approx(allowed / rms([&](auto r, auto k) { return about.data[r].input(k, 0); })).epsilon(1e-6));
  CHECK(of(ConstantBias{0.1}, "torque", 1) == Approx(allowed / rms([](auto r, auto) { return r == 1 ? 1.0 : 0.0; })));
  CHECK(of(SensorScale{1.2}, "scale") == 0.2);
  CHECK(of(SensorOffset{0.3}, "angle") == 0.2);
  CHECK(of(CoggingTorque{}, "phase") == 2.0);  // declared
  // What does nothing may be anything.
  CHECK(of(InputSaturation{1e3}, "limit") > 1e6);
}

TEST_CASE("Priors that stand are left, also of parameters that the user frees", "[diagnose][fit]") {
  Linearised about(kPendulum, {recorded(Machine(kPendulum, {}), {.seconds = 4.0})}, 1e-3);
  about.problem.free = {"mass"};
  Fit fit = about.at_truth({{StribeckFriction{0.1, 0.2, 0.1}, 0, -1}, {ConstantBias{0.1}, 0, -1}});
  complete_priors(about.problem, fit);
  CHECK(fit.unknowns[0].prior_deviation == Approx(1.2));
  for (const Unknown& unknown : fit.unknowns) CHECK(unknown.prior_deviation > 0.0);
  const std::vector<Unknown> once = fit.unknowns;
  fit.effects[1].form = ConstantBias{0.7};
  fit.effects[0].form = StribeckFriction{0.3, 0.4, 0.1};
  complete_priors(about.problem, fit);
  for (std::size_t i = 0; i < once.size(); ++i) {
    INFO(once[i].name);
    CHECK(fit.unknowns[i].prior_deviation == (once[i].name == "static" ? 0.3 : once[i].prior_deviation));
  }
}
