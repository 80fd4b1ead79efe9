// Missing torques that are products of two causes, which no catalogue has: what stands in for them predicts fresh
// recordings.

#include "diagnose/discrepancy/selection.hpp"

#include <catch2/catch.hpp>

#include "diagnose/fit/free_runs.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::record;

namespace {

/// The pendulum as a machine that the user writes down, with a torque more.
Plant with_torque(const std::string& torque) {
  const auto& p = std::get<Pendulum>(kPendulum);
  const Named<double> parameters{{{"m", p.mass}, {"l", p.length}, {"c", p.friction}, {"g", p.gravity}, {"k", 0.0}}};
  return Custom(parameters, {"(u - c*v - m*g*l*sin(q) + " + torque + ")/(m*l*l)"}, {"m*l*l"});
}

/// Free-run errors of the nominal and of what stands in for the missing torque, in a recording that it has not seen;
/// what is said to cause it.
struct Errors {
  double before, after;
  Cause cause;
};
Errors on_fresh(const Machine& machine, double strength) {
  const std::vector<Measured> data{record(machine, -1.0, 51), record(machine, -1.0, 52), record(machine, -1.0, 53)};
  const std::vector<Measured> fresh{record(machine, -1.0, 54, 1.0, strength)};
  const ExplainOptions options{usual_effects(), {}};
  const Explanation found = explain(kPendulum, data, options);
  const std::vector<TorquePrior> prior = likely_torque_prior(kPendulum, data, found.noise);
  std::vector<Trajectory> motion, fresh_motion;
  for (const Measured& m : data) motion.push_back(smooth(kPendulum, m, found.noise, prior));
  for (const Measured& m : fresh) fresh_motion.push_back(smooth(kPendulum, m, found.noise, prior));
  const Discrepancy discrepancy(*found.measured, data), about_best(*found.linearisation, data);
  const SelectedDiscrepancy stands =
      select_discrepancy(found, discrepancy, about_best, found.measured->response->target(), data, motion, 1.0);
  const auto error = [&](const Corrected& model) {
    return free_runs(model, fresh, fresh_motion, 1.0, true, found.max_step).rms;
  };
  return {error({kPendulum, {}, {}}), error({stands.fit.plant, stands.fit.effects, stands.remainder}),
          stands.whole.leads()};
}

}  // namespace

TEST_CASE("A torque that depends on two causes together is modelled well enough for a fresh recording",
          "[diagnose][decline][slow]") {
  using enum Cause;
  const auto [torque, one, other] =
      GENERATE(table<std::string, Cause, Cause>({{"0.15*u*sin(4*q)", input, position},
                                                 {"-0.06*u*v*v", input, velocity},
                                                 {"-(abs(q - 0.4) < 0.3 ? 0.25*tanh(v/0.005) : 0)", velocity, position},
                                                 {"0.4*v*sin(5*q)", velocity, position},
                                                 {"-0.3*v*exp(-t/3)", velocity, Cause::time},
                                                 {"0.3*v*sin(t)", velocity, Cause::time},
                                                 {"0.2*u*sin(2*t)", input, Cause::time}}));
  INFO(torque);
  REQUIRE(with_torque("0") != kPendulum);
  const Errors errors = on_fresh(Machine(with_torque(torque), {}), 1.0);
  CHECK(errors.before > 4.0 * testing::kPendulumNoise);
  CHECK(errors.after < 0.5 * errors.before);
  CHECK((errors.cause == one || errors.cause == other));
}

TEST_CASE("A law of few numbers holds where the machine is driven harder than in any recording it was learnt from",
          "[diagnose][decline][slow]") {
  constexpr double kStrength = 1.3;
  SECTION("input") {
    const Errors errors = on_fresh(Machine(with_torque("-0.3*(u > 0 ? u : 0) + 0.2*sqrt(abs(u))"), {}), kStrength);
    CHECK(errors.before > 10.0 * testing::kPendulumNoise);
    CHECK(errors.after < 0.2 * errors.before);
  }
  SECTION("position and velocity") {
    const Errors errors = on_fresh(Machine(with_torque("-0.3*abs(q)*v"), {}), kStrength);
    CHECK(errors.before > 10.0 * testing::kPendulumNoise);
    CHECK(errors.after < 0.2 * errors.before);
  }
  SECTION("history") {  // a spring behind a damper: m - v, m' = (v - m) / 0.5
    const Remainder element{{{LateVelocity{.time_constant = 0.5}, 0, -1, 0.4}}, {}};
    const Errors errors = on_fresh(Machine(kPendulum, {}, element), kStrength);
    CHECK(errors.before > 10.0 * testing::kPendulumNoise);
    CHECK(errors.after < 0.2 * errors.before);
  }
  SECTION("history of the input") {
    const Term swings{RingInput{.frequency = 15.0, .damping = 0.12}};  // a belt
    const Term leaks{LateInput{.time_constant = 0.8}, 0, -1, -0.3};
    const Term now{PowerInput{.exponent = 1.0, .odd = true}, 0, -1, -0.3};
    const Term slow{Slew{.rate = 8.0}};
    const Remainder drive = GENERATE_COPY(Remainder{{swings}, {}}, Remainder{{leaks, now}, {}}, Remainder{{slow}, {}});
    INFO(name_of(drive.terms.front().basis));
    const Errors errors = on_fresh(Machine(kPendulum, {}, drive), kStrength);
    CHECK(errors.before > 10.0 * testing::kPendulumNoise);
    CHECK(errors.after < 0.2 * errors.before);
  }
}
