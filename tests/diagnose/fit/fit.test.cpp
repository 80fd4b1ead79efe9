// Laws of fits: hidden states after a gap, sets that contain one another, laws that add nothing.

#include <catch2/catch.hpp>
#include <cmath>

#include "diagnose/motion/operating_range.hpp"
#include "diagnose/search/explain.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;

using testing::kPendulum, testing::record;

namespace {

/// Of recordings of a machine with a set of effects, the set or its equivalent is most probable, by less than so many
/// `nats`.
void check_equivalents_are_said(const Plant& plant, const std::vector<Effect>& set, double nats) {
  const std::vector<std::vector<Effect>> others = equivalents(set);
  REQUIRE(others.size() == 1);
  const Machine machine(plant, set);
  const std::vector<Measured> data{record(machine, -1.0, 91), record(machine, -1.0, 92)};
  const Explanation found = explain(plant, data, {usual_effects(), {}});
  double said = -kInfinity, equivalent = -kInfinity;
  for (const Candidate& candidate : found.candidates) {
    if (key(candidate.fit.effects) == key(set)) said = candidate.fit.log_evidence;
    if (key(candidate.fit.effects) == key(others[0])) equivalent = candidate.fit.log_evidence;
  }
  CAPTURE(key(set), key(found.best().fit.effects), said, equivalent);
  CHECK(std::abs(said - equivalent) < nats);
  CHECK(std::max(said, equivalent) == found.best().fit.log_evidence);
}

}  // namespace

TEST_CASE("Friction that gives before it slides is found across a gap, after which its state is not known",
          "[diagnose][fit][slow]") {
  const PreslidingHysteresis hidden{12.0, 0.25};
  const Machine machine(kPendulum, {{hidden, 0, -1}});
  const std::vector<Measured> data{record(machine, 4.3, 1), record(machine, 6.1, 2)};
  const Explanation found = explain(kPendulum, data, {usual_effects(), {}});
  const Fit& best = found.best().fit;
  REQUIRE(best.effects.size() == 1);
  const auto* law = best.effects[0].form.get_if<PreslidingHysteresis>();
  REQUIRE(law != nullptr);
  CHECK(std::abs(law->stiffness - hidden.stiffness) < 4.0 * best.deviation(0, "stiffness"));
  CHECK(std::abs(law->level - hidden.level) < 4.0 * best.deviation(0, "level"));
  CHECK(found.p_value(best) > 1e-3);
}

TEST_CASE("A spring between motor and joint is found where it is asked for, in recordings that begin while it swings",
          "[diagnose][fit][slow]") {
  const JointElasticity hidden{60.0, 0.6, 0.1};
  const Machine machine(kPendulum, {{hidden, 0, -1}});
  const std::vector<Measured> data{testing::without_beginning(record(machine, 4.3, 1), 130),
                                   testing::without_beginning(record(machine, -1.0, 2), 207)};
  std::vector<std::size_t> asked = usual_effects();
  asked.push_back(EffectForm(hidden).index());
  const Explanation found = explain(kPendulum, data, {asked, {}});
  const Fit& best = found.best().fit;
  CAPTURE(key(best.effects));
  REQUIRE(best.effects.size() == 1);
  const auto* law = best.effects[0].form.get_if<JointElasticity>();
  REQUIRE(law != nullptr);
  CHECK(std::abs(law->stiffness - hidden.stiffness) < 4.0 * best.deviation(0, "stiffness"));
  CHECK(std::abs(law->damping - hidden.damping) < 4.0 * best.deviation(0, "damping"));
  CHECK(std::abs(law->inertia - hidden.inertia) < 4.0 * best.deviation(0, "inertia"));
  CHECK(best.deviation(0, "stiffness") < 0.1 * hidden.stiffness);
  CHECK(found.p_value(best) > 1e-3);
}

TEST_CASE("A lag is found wherever it stands when a recording begins", "[diagnose][fit][slow]") {
  const double part = GENERATE(0.0, 1.0, -0.5);
  const double lag = GENERATE(0.05, 0.3);
  CAPTURE(part, lag);
  const Machine machine(kPendulum, {{CoulombFriction{0.15}, 0, -1}, {ActuatorLag{lag}, 0, -1}});
  const std::vector<Measured> data{record(machine, -1.0, 5, part), record(machine, 4.0, 6, part)};
  const Explanation found = explain(kPendulum, data, {usual_effects(), {}});
  const Fit& best = found.best().fit;
  CHECK(key(best.effects) == key(machine.effects()));
  CHECK(found.p_value(best) > 1e-3);
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const auto* law = best.effects[e].form.get_if<ActuatorLag>();
    if (law == nullptr) continue;
    CHECK(std::abs(law->time_constant - lag) < 4.0 * best.deviation(static_cast<int>(e), "time_constant"));
  }
}

TEST_CASE("Among finalists a larger set fits no worse than the sets that it contains", "[diagnose][fit][slow]") {
  int compared = 0;
  for (const EffectForm& hidden :
       {EffectForm(CoulombFriction{0.2}), EffectForm(StribeckFriction{0.1, 0.22, 0.2}), EffectForm(LinearSpring{0.4}),
        EffectForm(InputDelay{0.03}), EffectForm(CoggingTorque{0.2, 6.0, 1.0})}) {
    INFO(name_of(hidden));
    const Machine machine(kPendulum, {{hidden, 0, -1}});
    const std::vector<Measured> data{record(machine, -1.0, 3), record(machine, -1.0, 4)};
    const Explanation found = explain(kPendulum, data, {usual_effects(), {}});
    const double best = found.best().fit.log_evidence;
    CHECK(key(found.best().fit.effects) == key({{hidden, 0, -1}}));
    for (const Candidate& larger : found.candidates) {
      for (const Candidate& smaller : found.candidates) {
        const double behind = best - std::min(larger.fit.log_evidence, smaller.fit.log_evidence);
        if (behind > 15.0 || larger.fit.effects.size() != smaller.fit.effects.size() + 1) continue;
        for (std::size_t drop = 0; drop < larger.fit.effects.size(); ++drop) {
          if (key(without(larger.fit.effects, drop)) != key(smaller.fit.effects)) continue;
          INFO(key(larger.fit.effects) << "beside " << key(smaller.fit.effects));
          CHECK(larger.fit.sse < smaller.fit.sse + 2.0);
          ++compared;
        }
      }
    }
  }
  CHECK(compared > 5);
}

TEST_CASE("A law twice, or beside one that contains it, is no set of its own", "[diagnose][fit]") {
  const Effect coulomb{CoulombFriction{0.1}, 0, -1}, elsewhere{CoulombFriction{0.1}, 1, -1};
  const Effect stribeck{StribeckFriction{0.1, 0.2, 0.1}, 0, -1}, presliding{PreslidingHysteresis{10.0, 0.1}, 0, -1};
  CHECK(redundant({coulomb, coulomb}));
  CHECK(redundant({coulomb, stribeck}));
  CHECK(redundant({{ViscousFriction{0.1}, 0, -1}, {AsymmetricFriction{0.1, 0.2}, 0, -1}}));
  CHECK_FALSE(redundant({coulomb, elsewhere}));
  CHECK_FALSE(redundant({elsewhere, stribeck}));
  CHECK_FALSE(redundant({coulomb, presliding}));
  CHECK_FALSE(redundant({{TorqueStep{0.1, 2.0}, 0, 0}, {TorqueStep{0.1, 2.0}, 0, 1}}));
}

TEST_CASE("A tilt and an offset of the sensor are equivalents: the same is measured of a pendulum, and both are said",
          "[diagnose][fit][slow]") {
  const EffectForm form = GENERATE(EffectForm(GravityTilt{-0.05}), EffectForm(SensorOffset{0.05}));
  const std::vector<Effect> set{{StribeckFriction{0.07, 0.12, 0.09}, 0, -1}, {form, 0, -1}};
  REQUIRE(equivalents(set).size() == 1);
  CHECK(equivalents(equivalents(set)[0]) == std::vector<std::vector<Effect>>{set});
  check_equivalents_are_said(kPendulum, set, 1.0);
}

TEST_CASE(
    "A gain of the input and a scale of the sensor are equivalents: the same is measured of a mass, and both are said",
    "[diagnose][fit][slow]") {
  const EffectForm form = GENERATE(EffectForm(InputGain{0.72}), EffectForm(SensorScale{1.3}));
  check_equivalents_are_said(Mass{.mass = 1.4, .friction = 0.8}, {{Backlash{0.2}, 0, -1}, {form, 0, -1}}, 3.0);
}

TEST_CASE("Starts are handed down from sets that contain one another, and from no others", "[diagnose][fit]") {
  const Effect coulomb{CoulombFriction{0.3}, 0, -1}, spring{LinearSpring{2.0}, 0, -1};
  const Effect stribeck{StribeckFriction{1.0, 2.0, 0.5}, 0, -1};
  const auto smaller = starts_from({{CoulombFriction{9.0}, 0, -1}}, {coulomb, spring});
  REQUIRE(smaller.size() == 1);
  CHECK(smaller[0] == std::vector<Effect>{coulomb});
  const auto richer = starts_from({stribeck, spring}, {spring, coulomb});
  REQUIRE_FALSE(richer.empty());
  for (const std::vector<Effect>& start : richer) {
    CHECK(key(start) == key({stribeck, spring}));
    CHECK(start[1].form.get<StribeckFriction>().coulomb == 0.3);
  }
  const auto plain = starts_from({coulomb, spring}, {stribeck, spring});
  REQUIRE(plain.size() == 1);
  CHECK(plain[0][0].form.get<CoulombFriction>().level == 1.0);
  CHECK(starts_from({spring}, {coulomb}).empty());
  CHECK(starts_from({coulomb, spring}, {coulomb}).empty());
}

TEST_CASE("What the user's catalogue does not hold is not said, whatever resembles it", "[diagnose][fit]") {
  const EffectForm hidden = GENERATE(EffectForm(StribeckFriction{0.1, 0.22, 0.2}), EffectForm(CoulombFriction{0.2}),
                                     EffectForm(PreslidingHysteresis{12.0, 0.25}));
  const std::size_t only = GENERATE(EffectForm(StribeckFriction{}).index(), EffectForm(CoulombFriction{}).index(),
                                    EffectForm(PreslidingHysteresis{}).index());
  INFO(name_of(hidden) << " hidden, allowed " << only);
  const std::vector<Measured> data{record(Machine(kPendulum, {{hidden, 0, -1}}), -1.0, 6)};
  const Explanation found = explain(kPendulum, data, {{only}, {}});
  CHECK_FALSE(found.best().fit.effects.empty());
  for (const Candidate& candidate : found.candidates) {
    for (const Effect& effect : candidate.fit.effects) CHECK(effect.form.index() == only);
  }
}

TEST_CASE("A catalogue of which nothing can act leaves the nominal alone", "[diagnose][fit]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {{CoulombFriction{0.2}, 0, -1}}), -1.0, 5)};
  const Explanation found = explain(kPendulum, data, {{EffectForm(CouplingTorque{}).index()}, {}});
  CHECK(found.candidates.size() == 1);
  CHECK(found.best().fit.effects.empty());
  CHECK(found.p_value(found.best().fit) < 1e-6);
}

TEST_CASE("A fit's evidence is a number though its parameters do the same, and none where jacobian are none",
          "[diagnose][fit]") {
  const Machine machine(kPendulum, {{CoulombFriction{0.3}, 0, -1}, {ViscousFriction{0.2}, 0, -1}});
  const std::vector<Measured> data{record(machine, -1.0, 5)};
  const ExplainOptions options{{EffectForm{CoulombFriction{}}.index(), EffectForm{ViscousFriction{}}.index()}, {}};
  const Explanation found = explain(kPendulum, data, options);
  const FitProblem problem = problem_about(*found.measured, found, data, options);
  Fit fit = found.best().fit;
  REQUIRE(fit.unknowns.size() == 2);
  Eigen::MatrixXd jacobian(fit.residual.size(), 2);
  jacobian.col(0) = Eigen::VectorXd::LinSpaced(jacobian.rows(), -1.0, 1.3);
  jacobian.col(1) = jacobian.col(0) * 0.7;
  for (const double size : {1.0, 1e6, 1e9, 1e12}) {
    INFO(size);
    weigh(problem, fit, size * jacobian);
    CHECK(std::isfinite(fit.log_evidence));
  }
  jacobian(0, 0) = std::nan("");
  weigh(problem, fit, jacobian);
  CHECK(fit.log_evidence == -kInfinity);
}

TEST_CASE("However often a recording is sampled, simulations of it err by less than the noise", "[diagnose][fit]") {
  const double rate = GENERATE(100.0, 200.0, 400.0);
  constexpr double kNoise = 2e-5, kSeconds = 6.0;
  const Plant quick = Pendulum{.length = 0.02, .friction = 1e-4, .mass = 1.0};
  const Machine machine(quick, {});
  const auto count = static_cast<Eigen::Index>(kSeconds * rate);
  Measured data{"test", {}, {}, Eigen::MatrixXd::Zero(count, 1), 0.0, false};
  for (Eigen::Index k = 0; k < count; ++k) data.time.push_back(static_cast<double>(k) / rate);
  const auto drives = machine.drives(data.time, data.input);
  StateVector start(2);
  start << 2.0, 0.0;
  const auto run = [&](Eigen::Index last, double step) {
    return machine.run(start, data.time, drives, 0, static_cast<std::size_t>(last), step);
  };
  data.position = run(count - 1, 1e-4);
  RandomStream random(7);
  for (double& x : data.position.reshaped()) x += kNoise * draw_normal(random);
  const Explanation found = explain(quick, {data}, {{}, {}});
  const auto second = static_cast<Eigen::Index>(rate);
  const Eigen::MatrixXd error = run(second, found.max_step) - run(second, 1e-4);
  CAPTURE(rate, found.max_step);
  CHECK(std::sqrt(error.squaredNorm() / static_cast<double>(error.size())) < 0.1 * kNoise);
}

TEST_CASE("A window that begins far from where the machine was is found again", "[diagnose][fit][slow]") {
  const double position = GENERATE(0.0, 2.5, -4.0), velocity = GENERATE(8.0, -12.0);
  CAPTURE(position, velocity);
  const Machine machine(kPendulum, {{CoulombFriction{0.15}, 0, -1}});
  const std::vector<Measured> data{record(machine, -1.0, 7), record(machine, -1.0, 8)};
  const ExplainOptions options{usual_effects(), {}};
  const Explanation found = explain(kPendulum, data, options);
  const FitProblem problem = problem_about(*found.linearisation, found, data, options);
  const Fit& best = found.best().fit;
  std::vector<SegmentState> starts = best.initial_states;
  starts[2].head(2) += StateVector{{position, velocity}};
  REQUIRE(begin(problem, best.effects, starts).sse > 100.0 * best.sse);
  CHECK(fit(problem, best.effects, starts).sse < best.sse + 1.0);
}

TEST_CASE("A free parameter of the user's machine may have any name, also one that an effect has", "[diagnose][fit]") {
  const auto plant = [](double drag) { return Custom({{{"static", drag}}}, {"u - static*v - 4*sin(q)"}, {}); };
  const std::vector<Measured> data{record(Machine(plant(0.5), {}), -1.0, 31)};
  const Explanation found = explain(plant(0.4), data, {{EffectForm(StribeckFriction{}).index()}, {"static"}});
  const Fit& alone = found.without_effects().fit;
  REQUIRE(alone.unknowns.size() == 1);
  CHECK(std::abs(alone.unknowns[0].value - 0.5) < 4.0 * alone.deviation(-1, "static"));
  CHECK(alone.unknowns[0].prior_mean == 0.4);
  CHECK(found.p_value(alone) > 1e-3);
}

TEST_CASE("Bounds, priors and steps of a fit are those that the effects declare", "[diagnose][fit]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {}), -1.0, 32)};
  const std::vector<Trajectory> paths = smooth_all(kPendulum, data, Eigen::VectorXd::Constant(1, 3e-4));
  const auto of = [&](const EffectForm& form, std::string_view name) {
    for (const Unknown& unknown : list_unknowns(kPendulum, kPendulum, {{form, 0, -1}}, {}, data, paths)) {
      if (unknown.name == name) return unknown;
    }
    throw std::invalid_argument("no such parameter");
  };
  const OperatingRange s = operating_range(data, paths, 0);
  const double longest = data[0].time.back();
  const Unknown at_rest = of(StribeckFriction{0.2, 0.3, 0.1}, "static");
  CHECK(at_rest.prior_mean == 0.2);
  CHECK(at_rest.prior_deviation == 0.2);
  CHECK(of(StribeckFriction{0.1, 0.3, 0.1}, "static").prior_deviation == 0.15);
  CHECK(of(StribeckFriction{}, "velocity").prior_deviation == Approx(0.3 * 0.99));
  CHECK(of(InputDelay{0.1}, "delay").step == Approx(0.005));
  CHECK(of(InputDelay{0.2}, "delay").step == Approx(0.01));
  CHECK(of(InputGain{1.5}, "gain").prior_mean == 1.0);
  CHECK(of(InputGain{1.5}, "gain").prior_deviation == 0.0);
  CHECK(of(TorqueStep{1.0, 3.0}, "time").high == Approx(longest));
  CHECK(of(TorqueStep{1.0, 3.0}, "time").step == Approx(0.02));
  CHECK(of(PeriodicDisturbance{}, "frequency").low == Approx(1.0 / longest));
  CHECK(of(PeriodicDisturbance{}, "frequency").high == Approx(314.159).epsilon(1e-5));
  CHECK(of(CoggingTorque{}, "phase").step == 0.01);
  CHECK(of(CoggingTorque{}, "order").prior_deviation == Approx(0.3 * 28.0));
  CHECK(of(HardStop{}, "position").prior_deviation == Approx(0.3 * (s.highest - s.lowest)));
}
