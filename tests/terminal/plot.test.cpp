#include "terminal/plot.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <sstream>

#include "base/error.hpp"

using namespace bayesctrl;

namespace {

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> list;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) list.push_back(line);
  return list;
}

const PlotStyle kSmall{.width = 14, .rows = 2, .colour = false};  // 10 columns of labels, 4 x 2 characters

}  // namespace

TEST_CASE("A rising line goes from the lower left to the upper right", "[terminal]") {
  const std::vector<std::string> found = lines(plot("q [rad]", {0, 7}, {0, 7}, kSmall));
  REQUIRE(found.size() == 4);  // title, two rows, the range of time
  CHECK(found[0] == "          q [rad]");
  CHECK(found[1] == "        7 \u2800\u2800\u2860\u280a");
  CHECK(found[2] == "        0 \u2860\u280a\u2800\u2800");
}

TEST_CASE("Every line of a plot has the width that was asked for at most, whatever the values are", "[terminal]") {
  const double nan = std::nan(""), inf = HUGE_VAL;
  const std::vector<double> time{0, 1, 2, 3, 4, 5};
  for (const std::vector<double>& y : std::vector<std::vector<double>>{{0, 1, 0, -1, 0, 1},
                                                                       {3, 3, 3, 3, 3, 3},
                                                                       {0, 0, 0, 0, 0, 0},
                                                                       {nan, nan, nan, nan, nan, nan},
                                                                       {1, nan, inf, -inf, 2, 1},
                                                                       {1e300, -1e300, 1e-300, 0, 0, 0},
                                                                       {-1234.5678, 99999.9, 0, 0, 0, 0}}) {
    for (const int width : {20, 41, 80, 200}) {
      const std::vector<std::string> found = lines(plot("u", time, y, {width, 5, false}));
      REQUIRE(found.size() == 7);
      for (const std::string& line : found) CHECK(shown_length(line) <= static_cast<std::size_t>(width));
    }
  }
  CHECK(lines(plot("none", {}, {}, kSmall)).size() == 4);
  CHECK_THROWS_AS(plot("u", {0, 1}, {0}, kSmall), std::invalid_argument);
}

TEST_CASE("Colour surrounds the curve alone, and only where it is wanted", "[terminal]") {
  const std::string plain = plot("u", {0, 1}, {0, 1}, kSmall);
  std::string coloured = plot("u", {0, 1}, {0, 1}, {.width = 14, .rows = 2, .colour = true});
  CHECK(plain.find('\033') == std::string::npos);
  CHECK(coloured.find("\033[36m") != std::string::npos);
  for (const std::string code : {"\033[36m", "\033[0m"}) {
    for (std::size_t at = coloured.find(code); at != std::string::npos; at = coloured.find(code))
      coloured.erase(at, code.size());
  }
  CHECK(coloured == plain);
}

TEST_CASE("A curve begins anew where time goes back", "[terminal]") {
  const std::string joined = plot("q", {0, 10, 20}, {0, 10, 0}, kSmall),
                    apart = plot("q", {0, 20, 10}, {0, 0, 10}, kSmall);
  CHECK(joined != apart);
  CHECK(plot("q", {0, 20, 0, 20}, {0, 0, 10, 10}, kSmall).find("\u2847") == std::string::npos);  // no upright stroke
}

TEST_CASE("Columns are drawn in pairs over the time", "[terminal]") {
  const Table table{{{"set", "", std::vector<Cell>{Cell("a"), Cell("a")}},
                     {"t", "s", std::vector<double>{0, 1}},
                     {"q", "rad", std::vector<double>{0, 1}},
                     {"u", "N m", std::vector<double>{1, 0}}}};
  const std::vector<std::string> two = lines(plot_columns(table, {"q", "u"}, {80, 5, false}));
  CHECK(two.size() == 7);
  CHECK_THAT(two[0], Catch::Contains("q [rad]") && Catch::Contains("u [N m]"));
  CHECK(lines(plot_columns(table, {"q", "u", "q"}, {80, 5, false})).size() == 14);
  CHECK_THROWS_AS(plot_columns(table, {"v"}, {80, 5, false}), DataError);
}
