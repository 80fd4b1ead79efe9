// What a verdict is in words: the numbers of the effects, the gain, what is certain beside a remainder.

#include "diagnose/verdict/sentence.hpp"

#include <catch2/catch.hpp>

using namespace bayesctrl;

namespace {

ExplainedEffect effect(const std::string& name, int joint, const std::string& parameter, double value,
                       const std::string& unit, double inclusion, double share) {
  ExplainedEffect one;
  one.name = name;
  one.joint = joint;
  one.parameters.items.emplace_back(parameter, Estimate{value, 0.1 * value, unit});
  one.inclusion = inclusion;
  one.share = share;
  return one;
}

Diagnosis slide() {
  Diagnosis d;
  d.verdict = Verdict::named;
  d.joints = 1;
  d.fit.unit = "m";
  d.fit.noise_floor = 1e-6;
  d.fit.train = {4e-3, 4e-3, 5e-5, {}, {}};
  d.explanation.effects = {effect("coulomb_friction", 1, "level", 20.2, "N", 0.999, 0.9)};
  d.explanation.probability = 0.98;
  return d;
}

Diagnosis arm() {
  Diagnosis d = slide();
  d.verdict = Verdict::unknown;
  d.joints = 2;
  d.explanation.effects = {effect("coulomb_friction", 1, "level", 0.2, "N m", 0.99, 0.6),
                           effect("input_gain", 2, "gain", 1.1, "", 0.4, 0.1)};
  d.indistinguishable = {{"coulomb_friction@1", "stribeck_friction@1"}};
  d.mismatch.depends_on.of[1] = 0.8;
  d.remainder = Unexplained{0.1, {}};
  d.remainder->depends_on.of[4] = 0.7;
  return d;
}

}  // namespace

TEST_CASE("A named effect is said with its number and with how much less simulations err", "[diagnose]") {
  Diagnosis d = slide();
  CHECK(sentence(d) ==
        "The model lacks Coulomb friction (level 20.2 N). With it simulations err by 5e-05 m instead of 0.004 m, 80 "
        "times "
        "less. Probability 98 %.");
  d.fit.held_out = {8e-3, 8e-3, 1.05e-6, {}, {}};  // what was held out is the stronger proof
  CHECK_THAT(sentence(d), Catch::Contains("err by 1.05e-06 m instead of 0.008 m, which is the sensor's noise."));
  d.fit.held_out = {8e-3, 8e-3, 9e-3, {}, {}};  // no gain is none
  CHECK_THAT(sentence(d), !Catch::Contains("simulations"));
}

TEST_CASE("What is there but hardly matters is told as a trace, not as an equal", "[diagnose]") {
  Diagnosis d = slide();
  d.explanation.effects.push_back(effect("input_gain", 1, "gain", 1.00024, "", 0.99, 1e-5));
  CHECK_THAT(sentence(d),
             Catch::StartsWith("The model lacks Coulomb friction (level 20.2 N). There are traces of input "
                               "gain (gain 1, 0.001 % of the error). With it simulations err"));
  d.explanation.effects.erase(d.explanation.effects.begin());
  CHECK_THAT(sentence(d), Catch::StartsWith("The model lacks input gain (gain 1)."));

  Diagnosis beside = arm();  // and so beside a remainder
  beside.explanation.effects.push_back(effect("backlash", 2, "width", 0.05, "N m", 0.99, 0.0022));
  CHECK_THAT(sentence(beside), Catch::Contains("60 % of the error). Something else is missing, which depends on what "
                                               "was before most. There are traces of backlash in joint 2 (width 0.05 "
                                               "N m, 0.22 % of the error). Perhaps part of it: input gain"));
  beside.verdict = Verdict::ambiguous;
  CHECK_THAT(sentence(beside), Catch::EndsWith("but not surely. There are traces of backlash in joint 2 (width 0.05 "
                                               "N m, 0.22 % of the error)."));
  beside.verdict = Verdict::unknown;
  beside.explanation.effects.erase(beside.explanation.effects.begin(), beside.explanation.effects.end() - 1);
  CHECK_THAT(sentence(beside), Catch::StartsWith("Something is missing that no known effect explains"));
}

TEST_CASE("What is certain beside a remainder comes first, then what else there is and what may be part of it",
          "[diagnose]") {
  Diagnosis d = arm();
  CHECK(
      sentence(d) ==
      "Certain: Coulomb friction or Stribeck friction in joint 1 (level 0.2 N m, 60 % of the error). Something else is "
      "missing, which depends on what was before most. Perhaps part of it: input gain in joint 2 (gain 1.1).");
  d.explanation.effects.front().inclusion = 0.7;
  CHECK_THAT(sentence(d), Catch::StartsWith("Something is missing that no known effect explains; it depends on the "
                                            "velocity most. Perhaps part of it: Coulomb friction"));
  d.explanation.effects.clear();
  d.mismatch.depends_on = {};
  CHECK(sentence(d) == "Something is missing that no known effect explains.");
}

TEST_CASE("Laws any of which alone would do are told instead of what may be part of it", "[diagnose]") {
  Diagnosis d = arm();
  d.explanation.effects.front().inclusion = 0.5;
  d.alone = Alone{{{{"coulomb_friction@1", 0.999}, {"constant_bias@1", 0.99}, {"viscous_friction@1", 0.985}}}, true};
  CHECK(sentence(d) ==
        "Something is missing. Any of these alone would take away nearly all of it: Coulomb friction in joint 1, "
        "constant bias in joint 1 or viscous friction in joint 1. The recordings hardly tell them apart, as the joint "
        "moves one way only: record it both ways and at several speeds.");
  d.alone->one_way = false;
  CHECK_THAT(sentence(d), Catch::EndsWith("The recordings hardly tell them apart."));
}

TEST_CASE("An ambiguous set is said as a whole, with its probability", "[diagnose]") {
  Diagnosis d = arm();
  d.verdict = Verdict::ambiguous;
  d.explanation.probability = 0.4;
  CHECK(
      sentence(d) ==
      "Something is missing, most probably Coulomb friction or Stribeck friction in joint 1 (level 0.2 N m) and input "
      "gain in joint 2 (gain 1.1) (40 %), but not surely.");
}

TEST_CASE("Numbers of one kind are said together, others are left to the list", "[diagnose]") {
  Diagnosis d = slide();
  d.explanation.effects = {effect("asymmetric_friction", 1, "forward", 0.0, "N s/m", 0.99, 0.9)};
  d.explanation.effects[0].parameters.items.emplace_back("backward", Estimate{77.9, 1.0, "N s/m"});
  CHECK_THAT(sentence(d), Catch::Contains("asymmetric friction (forward 0, backward 77.9 N s/m)"));
  d.explanation.effects = {effect("hard_stop", 1, "position", 0.25, "m", 0.99, 0.9)};
  d.explanation.effects[0].parameters.items.emplace_back("stiffness", Estimate{400.0, 1.0, "N/m"});
  CHECK_THAT(sentence(d), Catch::Contains("hard stop (position 0.25 m)"));
}
