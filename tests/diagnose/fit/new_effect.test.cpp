// What an effect's own file is enough for: one that is known here alone, with a hidden state of two numbers that the
// motor's torque drives, is recognised, listed, drawn, simulated and found beside the whole catalogue. That the program
// names it once its line stands in the catalogue: scripts/reference/new_effect, which builds such a program.

#include <catch2/catch.hpp>
#include <cmath>

#include "diagnose/motion/hidden_torque.hpp"
#include "diagnose/search/screen.hpp"
#include "diagnose/settings.hpp"
#include "physics/machine/machine_state.hpp"
#include "support/fading_torque.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;

using testing::kPendulum, testing::kPendulumNoise, testing::whole_catalogue;

namespace {

/// An input that no sum of a few sines is.
double push(double t) {
  return 2.0 * std::sin(1.1 * t) + (std::sin(2.3 * t) > 0.2 ? 1.5 : -1.0) +
         (std::sin(5.1 * t + 0.7 * t * t) > 0.0 ? 0.7 : -0.7);
}

/// The pendulum with the effect, by Runge-Kutta steps of its own equations: q, v at the end of each period, in which
/// the input is held.
std::vector<StateVector> written_out(const FadingTorque& effect, double period, int count, int parts) {
  using State = std::array<double, 4>;  // q, v, z1, z2
  const Pendulum p = std::get<Pendulum>(kPendulum);
  const double inertia = p.mass * p.length * p.length;
  State x{0.3, 0.0, 0.0, 0.0};
  std::vector<StateVector> path{StateVector{{x[0], x[1]}}};
  for (int k = 0; k < count; ++k) {
    const double u = push(period * k), h = period / parts;
    const auto rate = [&](const State& s) {
      const double torque = u - p.friction * s[1] - p.mass * 9.81 * p.length * std::sin(s[0]) - effect.share * s[3];
      return State{s[1], torque / inertia, (u - s[2]) / effect.time_constant, (s[2] - s[3]) / effect.time_constant};
    };
    const auto along = [](State s, const State& d, double by) {
      for (std::size_t i = 0; i < 4; ++i) s[i] += by * d[i];
      return s;
    };
    for (int i = 0; i < parts; ++i) {
      const State k1 = rate(x), k2 = rate(along(x, k1, 0.5 * h)), k3 = rate(along(x, k2, 0.5 * h));
      const State k4 = rate(along(x, k3, h));
      for (std::size_t j = 0; j < 4; ++j) x[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
    }
    path.push_back(StateVector{{x[0], x[1]}});
  }
  return path;
}

}  // namespace

TEST_CASE("An effect of its own file is recognised by its role, and listed with its fields", "[diagnose][effects]") {
  STATIC_REQUIRE(HiddenStateEffect<FadingTorque>);
  STATIC_REQUIRE(LoadedEffect<FadingTorque>);
  STATIC_REQUIRE(kRoles<FadingTorque> == 1);
  STATIC_REQUIRE(hidden_count<FadingTorque>() == 2);
  STATIC_REQUIRE_FALSE(have_roles(static_cast<const std::variant<FadingTorque, OperatingRange>*>(nullptr)));
  CHECK(channel_of<FadingTorque>() == "drift");
  std::vector<std::string_view> names;
  FadingTorque form;
  FadingTorque::fields(form, [&](std::string_view name, double, const Info& info) {
    names.push_back(name);
    CHECK(info.required);
  });
  CHECK(names == std::vector<std::string_view>{"share", "time_constant"});
}

TEST_CASE("An effect of its own file is drawn as it declares", "[diagnose][effects]") {
  int draws = 0;
  const auto uniform = [&](double low, double high) {
    ++draws;
    return low + 0.25 * (high - low);
  };
  const auto [form, recording] = drawn_with_recording<FadingTorque>(uniform, {.strength = 0.4});
  CHECK(form == FadingTorque{0.4, 0.4});
  CHECK(recording == -1);
  CHECK(draws == 1);
}

TEST_CASE("A hidden state of two numbers settles and moves a machine as the equations say", "[diagnose][effects]") {
  const FadingTorque effect{0.35, 0.3};
  const JointState pulled{.motor_torque = 2.0};
  for (const double h : {0.01, 0.2, 1.5}) {
    const FadingTorque::State z = settled(effect, {}, pulled, h);
    const double x = h / effect.time_constant;
    CHECK(z[0] == Approx(2.0 * -std::expm1(-x)).epsilon(1e-3));
    CHECK(z[1] == Approx(2.0 * (1.0 - (1.0 + x) * std::exp(-x))).epsilon(2e-3));
  }

  // Stages as a machine goes through them, at steps of 5 ms, against a hundred times finer ones.
  const std::vector<StateVector> reference = written_out(effect, 0.01, 300, 200);
  const double h = 0.005;
  JointVector q = JointVector::Constant(1, 0.3), v = JointVector::Zero(1);
  HiddenVector z = HiddenVector::Zero(2), k1(2), k2(2), k3(2), k4(2);
  double largest = 0.0;
  for (int k = 0; k < 600; ++k) {
    const JointVector u = JointVector::Constant(1, push(0.01 * (k / 2)));
    const JointState seen{.motor_torque = u[0]};
    const auto acceleration = [&](const JointVector& position, const JointVector& velocity,
                                  const HiddenVector& hidden) {
      const Motion nominal = motion(kPendulum, position, velocity, u, 0.0);
      return JointVector(nominal.acceleration +
                         nominal.mobility *
                             JointVector::Constant(1, effect.torque_of(taken<FadingTorque>(hidden, 0), seen)));
    };
    HiddenVector z2(2), z3(2), z4(2), next(2);
    const JointVector a1 = acceleration(q, v, z);
    follow_one(effect, 0, seen, z, z, 0.5 * h, k1, z2);
    const JointVector v2 = v + 0.5 * h * a1, a2 = acceleration(q + 0.5 * h * v, v2, z2);
    follow_one(effect, 0, seen, z, z2, 0.5 * h, k2, z3);
    const JointVector v3 = v + 0.5 * h * a2, a3 = acceleration(q + 0.5 * h * v2, v3, z3);
    follow_one(effect, 0, seen, z, z3, h, k3, z4);
    const JointVector v4 = v + h * a3, a4 = acceleration(q + h * v3, v4, z4);
    follow_one(effect, 0, seen, z, z4, h, k4, next);
    k1 = (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
    follow_one(effect, 0, seen, z, {}, h, k1, next);
    q += h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4);
    v += h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4);
    z = next;
    if (k % 2 == 1) largest = std::max(largest, std::abs(q[0] - reference[static_cast<std::size_t>(k / 2 + 1)][0]));
  }
  CHECK(largest < 1e-6);
}

TEST_CASE("An effect of its own file is found beside the whole catalogue", "[diagnose][effects]") {
  const FadingTorque hidden{0.002, 0.3};  // it moves the pendulum by some thirty times the noise
  const std::vector<StateVector> path = written_out(hidden, 0.01, 1199, 10);
  RandomStream random(3);
  Measured recorded{"test", {}, Eigen::MatrixXd(1200, 1), Eigen::MatrixXd(1200, 1), 0.0, false};
  for (Eigen::Index k = 0; k < 1200; ++k) {
    recorded.time.push_back(0.01 * static_cast<double>(k));
    recorded.input(k, 0) = push(recorded.time.back());
    recorded.position(k, 0) = path[static_cast<std::size_t>(k)][0] + kPendulumNoise * draw_normal(random);
  }
  const std::vector<Measured> data{recorded};
  const Eigen::VectorXd noise = Eigen::VectorXd::Constant(1, kPendulumNoise);
  const std::vector<Trajectory> paths = smooth_all(kPendulum, data, noise);
  const LinearResponse response(kPendulum, data, paths, noise, windows(data, 2.0));
  const Forcing forcing(kPendulum, data, paths);

  Dictionary dictionary = make_dictionary(response, forcing, whole_catalogue());
  const std::vector<Shape<FadingTorque>> shapes = FadingTorque::shapes(operating_range(data, paths, 0));
  const int first = static_cast<int>(dictionary.suspects.size());
  dictionary.suspects.push_back({std::variant_size_v<EffectForm>, 0, {}});
  for (const Shape<FadingTorque>& shape : shapes) {
    const auto torque_at = hidden_torque(shape.members[0], 0.01);
    Eigen::VectorXd torque = Eigen::VectorXd::Zero(1200);
    for (Eigen::Index k = 0; k + 1 < 1200; ++k) torque[k] = torque_at({.motor_torque = recorded.input(k, 0)});
    const Eigen::MatrixXd a = forcing.acceleration(torque, 0, 0);
    const Eigen::Index column = dictionary.columns.cols();
    dictionary.columns.conservativeResize(Eigen::NoChange, column + 1);
    dictionary.scale.conservativeResize(column + 1);
    dictionary.scale[column] =
        kSettings.motion.prior_share * forcing.nominal_acceleration() / std::sqrt(a.squaredNorm() / 1200.0);
    dictionary.columns.col(column) = dictionary.scale[column] * response.responses({a.transpose().reshaped()});
    dictionary.suspects.back().atoms.push_back({{static_cast<int>(column)}, shape.sign, shape.low, shape.high, {}});
  }
  const Screen screen(dictionary, dictionary.columns, response.target());
  const Finding best = screen.all().front();
  CAPTURE(best.suspects, best.log_evidence);
  REQUIRE(best.suspects == std::vector<int>{first});
  const auto shape = static_cast<std::size_t>(best.atoms[0]);
  const int column = dictionary.suspects.back().atoms[shape].columns[0];
  const double coefficient = best.coefficients[0] * dictionary.scale[column];
  const FadingTorque found = FadingTorque::combined(shapes[shape], {&coefficient, 1});
  CHECK(found.share == Approx(hidden.share).epsilon(0.1));
  CHECK(found.time_constant == Approx(hidden.time_constant).epsilon(0.1));
}
