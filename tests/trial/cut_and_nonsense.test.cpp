// Recordings of which only the beginning is known, and motion that no machine has made.

#include <catch2/catch.hpp>
#include <sstream>

#include "trial/diagnosed.hpp"
#include "trial/nonsense.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

namespace {

trial::Case drawn(const std::string& family, int variant) {
  return trial::make_case({.seed = 2718, .pysindy_cases = false},
                          {family + "_" + std::to_string(variant), family, {}, variant});
}

/// The last time stamp of a recording.
double last_time(const std::string& csv) { return std::stod(csv.substr(csv.rfind('\n', csv.size() - 2) + 1)); }

}  // namespace

TEST_CASE("A cut case holds the first seconds of one recording, and nothing else", "[trial][slow]") {
  for (const auto& [variant, seconds, hidden] : {std::tuple{0, 1.3, 0}, {7, 2.0, 1}, {16, 8.0, 2}}) {
    const trial::Case one = drawn("cut", variant);
    REQUIRE(one.files.size() == 1);
    CHECK(one.spec["recordings"] == std::vector<std::string>{"train1.csv"});
    CHECK_FALSE(one.spec.contains("held_out"));
    CHECK(one.truth["effects"].size() == static_cast<std::size_t>(hidden));
    CHECK(one.truth["length"] == seconds);
    CHECK(last_time(one.files[0].second) < seconds);
    CHECK(last_time(one.files[0].second) > seconds - 0.05);
    CHECK(drawn("cut", variant).files == one.files);
  }
}

TEST_CASE("Nonsense hides nothing, and whatever is named there is wrong", "[trial][slow]") {
  const trial::Case one = drawn("nonsense", 4);
  CHECK(one.files.size() == 4);
  CHECK(one.truth["effects"].empty());
  CHECK(drawn("nonsense", 4).files == one.files);
  Diagnosis named = testing::diagnosed(one);
  CHECK_FALSE(trial::score(one.name, one.truth, named).confident);
  named.verdict = Verdict::named;
  const trial::Scored wrong = trial::score(one.name, one.truth, named);
  CHECK(wrong.wrong);
  CHECK(trial::summary({wrong})["nonsense: named"] == 1.0);
  CHECK_THAT(trial::tables({wrong}), Catch::Contains("| constant speed | 1 |"));
}

TEST_CASE("What is stated is counted by the length of the recording", "[trial]") {
  trial::Scored right;
  right.family = "cut";
  right.detail = {{"length", 1.3}};
  right.confident = right.named = true;
  right.probability = 0.95;
  right.effects = right.certain = right.certain_right = 1;
  trial::Scored wrong = right;
  wrong.wrong = true;
  wrong.certain_right = 0;
  CHECK_THAT(trial::tables({right, wrong}), Catch::Contains("| 1.3 | 2 | 2 | 2 | 1/2 (50 %) | 2 | 1/2 (50 %) |"));
  CHECK(trial::summary({right, wrong})["cut: names of probability >= 0.9 that are right"] == 0.5);
}
