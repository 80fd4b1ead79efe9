// Missing torques that are products of two causes, which no catalogue has: what stands in for them predicts fresh
// recordings.

#include "diagnose/decline.hpp"

#include <catch2/catch.hpp>

#include "diagnose/free_runs.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::record, testing::whole_catalogue;

namespace {

/// The pendulum as a machine that the user writes down, with a torque more.
Plant with_torque(const std::string& torque) {
  const auto& p = std::get<Pendulum>(kPendulum);
  const Named<double> parameters{{{"m", p.mass}, {"l", p.length}, {"c", p.friction}, {"g", p.gravity}, {"k", 0.0}}};
  return Custom(parameters, {"(u - c*v - m*g*l*sin(q) + " + torque + ")/(m*l*l)"}, {"m*l*l"});
}

}  // namespace

TEST_CASE("A torque that depends on two causes together is modelled well enough for a fresh recording",
          "[diagnose][decline]") {
  const std::string torque =
      GENERATE(as<std::string>{}, "0.15*u*sin(4*q)", "-0.06*u*v*v", "-(abs(q - 0.4) < 0.3 ? 0.25*tanh(v/0.005) : 0)",
               "0.4*v*sin(5*q)", "-0.3*v*exp(-t/3)");
  INFO(torque);
  const Machine machine(with_torque(torque), {});
  REQUIRE(with_torque("0") != kPendulum);
  const std::vector<Measured> data{record(machine, -1.0, 51), record(machine, -1.0, 52), record(machine, -1.0, 53)};
  const std::vector<Measured> fresh{record(machine, -1.0, 54)};
  const ExplainOptions options{whole_catalogue(), {}};
  const Explanation found = explain(kPendulum, data, options);
  const std::vector<TorquePrior> prior = likely_torque_prior(kPendulum, data, found.noise);
  std::vector<Trajectory> motion, fresh_motion;
  for (const Measured& m : data) motion.push_back(smooth(kPendulum, m, found.noise, prior));
  for (const Measured& m : fresh) fresh_motion.push_back(smooth(kPendulum, m, found.noise, prior));
  const Discrepancy discrepancy(*found.measured, data);
  const StandIn stands = stand_in(found, discrepancy, found.measured->response->target(), data, motion, 1.0);
  const double before = free_runs({kPendulum, {}, {}}, fresh, fresh_motion, 1.0, true, found.max_step).rms;
  const double after = free_runs({stands.fit.plant, stands.fit.effects, stands.remainder}, fresh, fresh_motion, 1.0,
                                 true, found.max_step)
                           .rms;
  CHECK(before > 4.0 * testing::kPendulumNoise);
  CHECK(after < 0.5 * before);
}
