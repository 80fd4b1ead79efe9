// The round trip of every effect in the catalogue: a machine is simulated with it and diagnosed without it.

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "trial/diagnosed.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

TEMPLATE_LIST_TEST_CASE("A machine simulated with an effect and diagnosed without it: the effect is named",
                        "[trial][round-trip][slow]", Catalogue) {
  const TrialSpec spec{.seed = 4, .lowest_noise = 3e-4, .highest_noise = 3e-3};
  const std::string name = "single_" + std::string(TestType::kName);
  trial::Case hidden = trial::make_case(spec, {name, "single", {EffectForm(TestType{}).index()}, 0});
  REQUIRE_FALSE(hidden.files.empty());
  if (EffectForm(TestType{}).roles().on_demand) hidden.spec["effects"] = {"usual", TestType::kName};
  const Diagnosis diagnosis = testing::diagnosed(hidden);
  const trial::Scored scored = trial::score(name, hidden.truth, diagnosis);
  INFO(hidden.truth.dump(1));
  INFO(to_json(diagnosis).dump(1));
  CHECK(scored.detected);
  CHECK(scored.named);
  CHECK_FALSE(scored.wrong);
  CHECK(scored.joint);
  CHECK(scored.after < 1.1);
}
