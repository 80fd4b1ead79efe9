// Laws of fits: hidden states after a gap, sets that contain one another, laws that add nothing.

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "diagnose/explain.hpp"
#include "physics/machine.hpp"

using namespace bayesctrl;

namespace {

const Plant kPendulum = Pendulum{.length = 0.8, .friction = 0.2, .mass = 0.6};

/// 12 s under a sum of sines with noise of 3e-4 rad; half a second is lost from `gap` on (none if negative).
Measured record(const Machine& machine, double gap, std::uint64_t seed) {
  RandomStream random(seed);
  Measured data{"test", {}, {}, {}, 0.0, false};
  std::vector<double> time;
  Eigen::MatrixXd input(1200, 1);
  const double phase = draw_uniform(random, 0.0, 6.0);
  for (int k = 0; k < 1200; ++k) {
    const double t = 0.01 * k;
    time.push_back(t);
    input(k, 0) = 2.5 * std::sin(1.1 * t + phase) + 1.5 * std::sin(3.7 * t) + std::sin(7.9 * t + phase);
  }
  StateVector start(2);
  start << 0.3, 0.0;
  const Eigen::MatrixXd q = machine.run(start, time, machine.drives(time, input), 0, 1199, 1e-3);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < 1200; ++k) {
    const double t = time[static_cast<std::size_t>(k)];
    if (gap < 0.0 || t < gap || t >= gap + 0.5) kept.push_back(k);
  }
  data.position = q(kept, Eigen::all);
  data.input = input(kept, Eigen::all);
  for (const Eigen::Index k : kept) data.time.push_back(time[static_cast<std::size_t>(k)]);
  for (double& x : data.position.reshaped()) x += 3e-4 * draw_normal(random);
  return data;
}

std::vector<std::size_t> whole_catalogue() {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < std::variant_size_v<EffectForm>; ++i) all.push_back(i);
  return all;
}

}  // namespace

TEST_CASE("Friction that gives before it slides is found across a gap, after which its state is not known",
          "[diagnose][fit]") {
  const PreslidingHysteresis hidden{12.0, 0.25};
  const Machine machine(kPendulum, {{hidden, 0, -1}});
  const std::vector<Measured> data{record(machine, 4.3, 1), record(machine, 6.1, 2)};
  const Explanation found = explain(kPendulum, data, {whole_catalogue(), {}});
  const Fit& best = found.best().fit;
  REQUIRE(best.effects.size() == 1);
  const auto* law = std::get_if<PreslidingHysteresis>(&best.effects[0].form);
  REQUIRE(law != nullptr);
  CHECK(std::abs(law->stiffness - hidden.stiffness) < 4.0 * best.deviation(0, "stiffness"));
  CHECK(std::abs(law->level - hidden.level) < 4.0 * best.deviation(0, "level"));
  CHECK(found.p_value(best) > 1e-3);
}

TEST_CASE("Among finalists a larger set fits no worse than the sets that it contains", "[diagnose][fit]") {
  const EffectForm hidden =
      GENERATE(EffectForm(CoulombFriction{0.2}), EffectForm(StribeckFriction{0.1, 0.22, 0.2}),
               EffectForm(LinearSpring{0.4}), EffectForm(InputDelay{0.03}), EffectForm(CoggingTorque{0.2, 6.0, 1.0}));
  INFO(name_of(hidden));
  const Machine machine(kPendulum, {{hidden, 0, -1}});
  const std::vector<Measured> data{record(machine, -1.0, 3), record(machine, -1.0, 4)};
  const Explanation found = explain(kPendulum, data, {whole_catalogue(), {}});
  CHECK(key(found.best().fit.effects) == key({{hidden, 0, -1}}));
  int compared = 0;
  for (const Candidate& larger : found.candidates) {
    for (const Candidate& smaller : found.candidates) {
      const double behind = found.best().fit.log_evidence - std::min(larger.fit.log_evidence, smaller.fit.log_evidence);
      if (behind > 15.0 || larger.fit.effects.size() != smaller.fit.effects.size() + 1) continue;
      for (std::size_t drop = 0; drop < larger.fit.effects.size(); ++drop) {
        if (key(without(larger.fit.effects, drop)) != key(smaller.fit.effects)) continue;
        INFO(key(larger.fit.effects) << "beside " << key(smaller.fit.effects));
        CHECK(larger.fit.squares < smaller.fit.squares + 2.0);
        ++compared;
      }
    }
  }
  CHECK(compared > 0);
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
    CHECK(std::get<StribeckFriction>(start[1].form).coulomb == 0.3);
  }
  CHECK(starts_from({spring}, {coulomb}).empty());
  CHECK(starts_from({coulomb, spring}, {coulomb}).empty());
}

TEST_CASE("A catalogue of which nothing can act leaves the nominal alone", "[diagnose][fit]") {
  const std::vector<Measured> data{record(Machine(kPendulum, {{CoulombFriction{0.2}, 0, -1}}), -1.0, 5)};
  const Explanation found = explain(kPendulum, data, {{EffectForm(CouplingTorque{}).index()}, {}});
  CHECK(found.candidates.size() == 1);
  CHECK(found.best().fit.effects.empty());
  CHECK(found.p_value(found.best().fit) < 1e-6);
}
