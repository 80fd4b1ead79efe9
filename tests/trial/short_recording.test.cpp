// Short recordings of the trial: drawn as they are described, the same each time, and diagnosed.

#include "trial/short_recording.hpp"

#include <catch2/catch.hpp>
#include <sstream>

#include "io/table.hpp"
#include "trial/diagnosed.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

namespace {

trial::Case drawn(int variant) {
  return trial::make_case({.seed = 3101}, {"short_" + std::to_string(variant), "short", {}, variant});
}

}  // namespace

TEST_CASE("A short recording has 10 s of one joint without an input, and up to three hidden effects", "[trial]") {
  for (int variant = 0; variant < 24; ++variant) {
    INFO(variant);
    const trial::Case one = drawn(variant);
    REQUIRE(one.files.size() == 2);
    CHECK(one.spec["recordings"].size() == 1);
    CHECK(one.truth["effects"].size() == static_cast<std::size_t>(variant / 3 % 4));
    CHECK(one.truth["level"] == std::array{0.0, 0.01, 0.05}[static_cast<std::size_t>(variant % 3)]);
    for (const auto& [file, csv] : one.files) {
      std::istringstream lines(csv);
      std::string line;
      int count = 0;
      while (std::getline(lines, line)) count += count == 0 || line.ends_with(",0") ? 1 : 1000;
      CHECK(count == 1 + 510);
    }
    const trial::Case again = drawn(variant);
    CHECK(again.files == one.files);
    CHECK(again.truth == one.truth);
  }
}

TEST_CASE("Short recordings: what is stated with 0.9 is right, and nothing is found where nothing is hidden",
          "[trial][slow]") {
  int named = 0, right = 0, certain = 0, hidden = 0;
  for (int variant = 0; variant < 24; ++variant) {
    const trial::Case one = drawn(variant);
    const trial::Scored scored = trial::score(one.name, one.truth, testing::diagnosed(one));
    const bool nothing = one.truth["effects"].empty();
    INFO(one.truth.dump(1));
    if (nothing) CHECK_FALSE(scored.detected);
    named += scored.confident;
    right += scored.confident && scored.named;
    certain += scored.certain;
    hidden += scored.certain_right;
  }
  CHECK(named >= 12);
  CHECK(right >= named - 2);
  CHECK(certain >= 24);
  CHECK(hidden >= certain - 2);
}
