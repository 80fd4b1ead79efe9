// What an effect's own file is enough for: one that is known here alone, with a hidden state of two numbers that the
// motor's torque drives, is listed, read from specs, drawn, simulated and named like any other of the catalogue.

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "diagnose/verdict/diagnose.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/read.hpp"
#include "physics/catalogue.hpp"
#include "physics/effect_law.hpp"
#include "physics/machine/simulation.hpp"
#include "spec/model.hpp"
#include "support/fading_torque.hpp"
#include "support/recorded_pendulum.hpp"
#include "support/runge_kutta.hpp"
#include "trial/diagnosed.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

using testing::kPendulum, testing::kPendulumNoise;

namespace {

/// An input that no sum of a few sines is, another for each shift.
double push(double t, double shift) {
  return 2.0 * std::sin(1.1 * t + shift) + (std::sin(2.3 * t) > 0.2 ? 1.5 : -1.0) +
         (std::sin(5.1 * t + 0.7 * t * t) > 0.0 ? 0.7 : -0.7);
}

/// The pendulum with the effect, by Runge-Kutta steps of its own equations: q, v at the end of each period, in which
/// the input is held.
std::vector<StateVector> written_out(const FadingTorque& effect, double period, int count, int parts,
                                     double shift = 0.0) {
  using State = std::array<double, 4>;  // q, v, z1, z2
  const Pendulum p = std::get<Pendulum>(kPendulum);
  const double inertia = p.mass * p.length * p.length;
  State x{0.3, 0.0, 0.0, 0.0};
  std::vector<StateVector> path{StateVector{{x[0], x[1]}}};
  for (int k = 0; k < count; ++k) {
    const double u = push(period * k, shift), h = period / parts;
    const auto rate = [&](const State& s, double /*t*/) {
      const double torque = u - p.friction * s[1] - p.mass * 9.81 * p.length * std::sin(s[0]) - effect.share * s[3];
      return State{s[1], torque / inertia, (u - s[2]) / effect.time_constant, (s[2] - s[3]) / effect.time_constant};
    };
    for (int i = 0; i < parts; ++i) x = testing::runge_kutta_step(x, h, rate);
    path.push_back(StateVector{{x[0], x[1]}});
  }
  return path;
}

}  // namespace

TEST_CASE("An effect of its own file is listed, and read from specs, while it belongs to the catalogue",
          "[diagnose][effects]") {
  const std::size_t before = catalogue().size();
  CHECK_THROWS_AS(EffectForm(FadingTorque{}), std::invalid_argument);
  {
    const AddedEffect<FadingTorque> added;
    REQUIRE(catalogue().size() == before + 1);
    CHECK(effect_names().back() == "fading_torque");
    const EffectForm form = FadingTorque{0.2, 0.4};
    CHECK(form.index() == before);
    CHECK(form.law().text == FadingTorque::kText);
    CHECK(form.law().hidden_count == 2);
    CHECK(form.roles().hidden_state);
    CHECK(form.roles().feels_load);
    CHECK_FALSE(form.roles().settles);
    CHECK(channel(form) == "drift");

    Model model;
    model.plant = kPendulum;
    model.effects = {{form, 0, -1}};
    const auto read_back = read<Model>(parse_yaml(to_yaml(to_json(model)), "model.yaml"));
    CHECK(read_back.effects == model.effects);
    CHECK(schema<Model>().dump().find("fading_torque") != std::string::npos);
    CHECK_THROWS_WITH(
        read<Model>(parse_yaml("plant: pendulum\neffects: [{type: fading_torque, share: 0.1, time_constant: 9}]", "m")),
        Catch::Contains("m:2") && Catch::Contains("from 0.01 to 5"));
  }
  CHECK(catalogue().size() == before);
  CHECK(effect_names().back() != "fading_torque");
}

TEST_CASE("An effect of its own file is drawn as it declares", "[diagnose][effects]") {
  const AddedEffect<FadingTorque> added;
  int draws = 0;
  const auto uniform = [&](double low, double high) {
    ++draws;
    return low + 0.25 * (high - low);
  };
  const auto [form, recording] = catalogue().back()->drawn(uniform, {.strength = 0.4});
  CHECK(form == EffectForm(FadingTorque{0.4, 0.4}));
  CHECK(recording == -1);
  CHECK(draws == 1);
}

TEST_CASE("A hidden state of two numbers settles and moves a machine as the equations say", "[diagnose][effects]") {
  const AddedEffect<FadingTorque> added;
  const FadingTorque effect{0.35, 0.3};
  const JointState pulled{.motor_torque = 2.0};
  for (const double h : {0.01, 0.2, 1.5}) {
    std::array<double, 2> z{};
    EffectForm(effect).settle(z, pulled, h);
    const double x = h / effect.time_constant;
    CHECK(z[0] == Approx(2.0 * -std::expm1(-x)).epsilon(1e-3));
    CHECK(z[1] == Approx(2.0 * (1.0 - (1.0 + x) * std::exp(-x))).epsilon(2e-3));
  }

  const int count = 300;
  const std::vector<StateVector> reference = written_out(effect, 0.01, count, 200);
  std::vector<double> time;
  Eigen::MatrixXd input(count + 1, 1);
  for (int k = 0; k <= count; ++k) {
    time.push_back(0.01 * k);
    input(k, 0) = push(time.back(), 0.0);
  }
  const Machine machine(kPendulum, {{effect, 0, -1}});
  const Eigen::MatrixXd q = machine.run(reference[0], time, machine.drives(time, input), 0, time.size() - 1);
  double largest = 0.0;
  for (Eigen::Index k = 0; k <= count; ++k) {
    largest = std::max(largest, std::abs(q(k, 0) - reference[static_cast<std::size_t>(k)][0]));
  }
  CHECK(largest < 1e-6);
}

TEST_CASE("An effect of its own file is named in the round trip of the trial", "[diagnose][effects][slow]") {
  const AddedEffect<FadingTorque> added;
  const TrialSpec spec{.seed = 4, .lowest_noise = 3e-4, .highest_noise = 3e-3};
  const trial::Case hidden = trial::make_case(spec, {"toy", "single", {EffectForm(FadingTorque{}).index()}, 0});
  REQUIRE_FALSE(hidden.files.empty());
  const trial::Scored scored = trial::score("toy", hidden.truth, testing::diagnosed(hidden));
  INFO(hidden.truth.dump(1));
  CHECK(scored.named);
  CHECK_FALSE(scored.wrong);
  CHECK(scored.after < 1.1);
}

TEST_CASE("An effect of its own file is named in recordings of a machine that is written out",
          "[diagnose][effects][slow]") {
  const AddedEffect<FadingTorque> added;
  const FadingTorque hidden{0.35, 0.3};
  const io_examples::Folder folder;
  FileBatch batch;
  RandomStream random(3);
  for (int run = 0; run < 2; ++run) {
    std::ostringstream csv;
    csv.precision(17);
    csv << "t,q,u\n";
    const std::vector<StateVector> path = written_out(hidden, 0.01, 1200, 10, 2.0 * run);
    for (int k = 0; k < 1200; ++k) {
      const double t = 0.01 * k, q = path[static_cast<std::size_t>(k)][0] + kPendulumNoise * draw_normal(random);
      csv << t << "," << q << "," << push(t, 2.0 * run) << "\n";
    }
    batch.add(folder.path() / ("run" + std::to_string(run) + ".csv"), csv.str());
  }
  Model model;
  model.plant = kPendulum;
  batch.add(folder.path() / "spec.yaml", to_yaml({{"name", "toy"},
                                                  {"model", to_json(model)},
                                                  {"signals", {{"time", "t"}, {"position", "q"}, {"input", "u"}}},
                                                  {"recordings", {"run0.csv", "run1.csv"}}}));
  batch.commit();
  const Diagnosis d = diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
  CHECK(d.verdict == Verdict::named);
  REQUIRE(d.explanation.effects.size() == 1);
  const ExplainedEffect& found = d.explanation.effects[0];
  CHECK(found.name == "fading_torque");
  CHECK(found.text == FadingTorque::kText);
  CHECK(found.parameters.find("share")->value == Approx(hidden.share).epsilon(0.05));
  CHECK(found.parameters.find("time_constant")->value == Approx(hidden.time_constant).epsilon(0.05));
}
