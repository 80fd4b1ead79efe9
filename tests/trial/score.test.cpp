// What is counted as right, wrong and declined.

#include "trial/score.hpp"

#include <catch2/catch.hpp>

using namespace bayesctrl;
using nlohmann::ordered_json;

namespace {

Diagnosis said(int joints, const std::string& name, int joint) {
  Diagnosis d;
  d.verdict = Verdict::named;
  d.joints = joints;
  d.units.resize(static_cast<std::size_t>(joints));
  d.mismatch.detected = true;
  d.mismatch.channel = Channel::drift;
  d.mismatch.joint = joint;
  d.explanation = {{{name, joint, {{{"level", {0.31, 0.01, "N m"}}}}, {}, ""}}, "", 0.95};
  d.fit.held_out = {0.1, 0.05, 0.002, {}, {}};
  return d;
}

ordered_json hidden(const std::string& name, int joint) {
  return {{"family", "single"},
          {"plant", "custom"},
          {"noise", 1e-3},
          {"effects", {{{"name", name}, {"joint", joint}, {"size", 9.0}, {"parameters", {{"level", 0.3}}}}}}};
}

}  // namespace

TEST_CASE("An effect in another joint of a custom machine is not the one that was hidden", "[trial]") {
  const trial::Scored right = trial::score("a", hidden("coulomb_friction", 2), said(2, "coulomb_friction", 2));
  CHECK(right.named);
  CHECK(right.joint);
  CHECK(right.channel);
  CHECK(right.said == "coulomb_friction@2");
  CHECK(right.parameters == 1);
  CHECK(right.covered == 1);
  CHECK(right.refit == Approx(50.0));
  const trial::Scored wrong = trial::score("b", hidden("coulomb_friction", 2), said(2, "coulomb_friction", 1));
  CHECK_FALSE(wrong.named);
  CHECK(wrong.wrong);
  CHECK_FALSE(wrong.joint);
  CHECK(wrong.hidden == "coulomb_friction@2");
  CHECK(trial::score("c", hidden("coulomb_friction", 1), said(1, "coulomb_friction", 1)).said == "coulomb_friction");
}

TEST_CASE("How many joints a machine has is taken from the truth, if that says so", "[trial]") {
  ordered_json truth = hidden("coulomb_friction", 1);
  truth["joints"] = 2;
  CHECK(trial::score("a", truth, said(1, "coulomb_friction", 1)).hidden == "coulomb_friction@1");
}

TEST_CASE("An ambiguous answer is right with the truth among its first three sets", "[trial]") {
  Diagnosis d = said(1, "stribeck_friction", 1);
  d.verdict = Verdict::ambiguous;
  d.alternatives = {{{"viscous_friction"}, 0.2, "", false}, {{"coulomb_friction"}, 0.1, "", false}};
  CHECK(trial::score("a", hidden("coulomb_friction", 1), d).named);
  d.alternatives.insert(d.alternatives.begin(), {{"quadratic_drag"}, 0.3, "", false});
  CHECK_FALSE(trial::score("b", hidden("coulomb_friction", 1), d).named);
  d.verdict = Verdict::named;
  CHECK(trial::score("c", hidden("coulomb_friction", 1), d).wrong);
  d.indistinguishable = {{"stribeck_friction", "coulomb_friction"}};
  CHECK(trial::score("d", hidden("coulomb_friction", 1), d).named);
  d.verdict = Verdict::unknown;
  CHECK(trial::score("e", hidden("coulomb_friction", 1), d).declined);
  d.verdict = Verdict::nothing_missing;
  CHECK_FALSE(trial::score("f", hidden("coulomb_friction", 1), d).detected);
}
