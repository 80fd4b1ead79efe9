// Physics that no catalogue has, one invention for each cause: declined, its cause found, and the simulation corrected.

#include <catch2/catch.hpp>

#include "trial/diagnosed.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

namespace {

void check_declined(int variant, const std::string& cause,
                    const TrialSpec& spec = {.seed = 8, .lowest_noise = 3e-4, .highest_noise = 1e-3}) {
  const std::string name = "outside_" + std::to_string(variant);
  const trial::Case hidden = trial::make_case(spec, {name, "outside", {}, variant});
  REQUIRE_FALSE(hidden.files.empty());
  REQUIRE(hidden.truth["outside"]["cause"] == cause);
  const Diagnosis diagnosis = testing::diagnosed(hidden);
  const trial::Scored scored = trial::score(name, hidden.truth, diagnosis);
  INFO(hidden.truth.dump(1));
  INFO(to_json(diagnosis).dump(1));
  CHECK(scored.detected);
  CHECK(scored.declined);
  CHECK(scored.cause);
  CHECK(scored.after < 0.5 * scored.refit);
}

}  // namespace

TEST_CASE("An invention that lives in position is declined and corrected", "[trial][slow]") {
  check_declined(0, "position");
}
TEST_CASE("A well that three effects imitate where the machine was seen is declined and corrected", "[trial][slow]") {
  check_declined(19, "position", {.seed = 86602540});
}
TEST_CASE("An invention that lives in velocity is declined and corrected", "[trial][slow]") {
  check_declined(2, "velocity");
}
TEST_CASE("An invention that lives in the input is declined and corrected", "[trial][slow]") {
  check_declined(5, "input");
}
TEST_CASE("An invention that lives in time is declined and corrected", "[trial][slow]") { check_declined(6, "time"); }
TEST_CASE("An invention that lives in history is declined and corrected", "[trial][slow]") {
  check_declined(7, "history");
}
TEST_CASE("A belt that slips, which remembers the input, is declined and corrected", "[trial][slow]") {
  check_declined(8, "history");
}
