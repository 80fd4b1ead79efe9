#include "terminal/progress.hpp"

#include <catch2/catch.hpp>

using namespace bayesctrl;

TEST_CASE("Durations are told in the two largest units, rounded up", "[terminal]") {
  CHECK(duration_text(0.0) == "0 s");
  CHECK(duration_text(0.2) == "1 s");
  CHECK(duration_text(59.0) == "59 s");
  CHECK(duration_text(59.5) == "1 min 00 s");
  CHECK(duration_text(185.0) == "3 min 05 s");
  CHECK(duration_text(7620.0) == "2 h 07 min");
  CHECK(duration_text(-1.0) == "0 s");
  CHECK(duration_text(1e300) == "277777 h 46 min");
}

TEST_CASE("Words choose how progress is shown; quiet means none", "[terminal]") {
  using Mode = Progress::Mode;
  for (const char* word : {"", "none", "bar", "text"}) CHECK(Progress::choose(word, true) == Mode::none);
  CHECK(Progress::choose("none", false) == Mode::none);
  CHECK(Progress::choose("bar", false) == Mode::bar);
  CHECK(Progress::choose("text", false) == Mode::text);
  CHECK(Progress::choose("", false) != Mode::none);
}
