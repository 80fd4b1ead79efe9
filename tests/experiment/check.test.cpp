#include "experiment/check.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "experiment/tabulate.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;

namespace {

PublishedCell cell(double value) {
  PublishedCell result;
  result.experiment = "e";
  result.controller = "c";
  result.metric = "energy";
  result.value = value;
  return result;
}

PublishedCell rounded(double value) {
  PublishedCell result = cell(value);
  result.rounded = true;
  return result;
}

PublishedCell relative(double value, double tolerance) {
  PublishedCell result = cell(value);
  result.relative = tolerance;
  return result;
}

PublishedCell absolute(double value, double tolerance) {
  PublishedCell result = cell(value);
  result.absolute = tolerance;
  return result;
}

/// A result of one row.
Table row(const std::string& experiment, const std::string& controller, const std::string& status, double energy) {
  return {{{"experiment", "", std::vector<Cell>{experiment}},
           {"controller", "", std::vector<Cell>{controller}},
           {"status", "", std::vector<Cell>{status}},
           {"energy", "", std::vector<double>{energy}},
           {"points", "", std::vector<Cell>{std::int64_t{7}}},
           {"empty", "", std::vector<Cell>{Cell{}}}}};
}

std::string verdict(const Table& results, const PublishedCell& published) {
  return column_texts(compare(results, {"T", "s", {published}}), "ok").front();
}

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("A rounded cell holds for what rounds to it, half away from zero", "[experiment]") {
  for (const double inside : {133.5, 134.0, 134.4999999}) CHECK(rounded(134).holds(inside));
  for (const double outside : {133.4999999, 134.5, -134.0, kNan, kInfinity}) CHECK_FALSE(rounded(134).holds(outside));
  CHECK(rounded(-3).holds(-3.4));
  CHECK(rounded(0).holds(-0.4));
}

TEST_CASE("A relative cell holds up to its edge on both sides, for either sign", "[experiment]") {
  for (const double inside : {90.0, 100.0, 110.0}) CHECK(relative(100, 0.1).holds(inside));
  for (const double outside : {89.999, 110.001, -100.0, kNan, kInfinity})
    CHECK_FALSE(relative(100, 0.1).holds(outside));
  CHECK(relative(-100, 0.1).holds(-110.0));
  CHECK_FALSE(relative(-100, 0.1).holds(-110.001));
  CHECK(relative(1, 0.1).holds(1.1));  // in binary, 1.1 - 1 exceeds 0.1 in the last bit
  CHECK(relative(0, 0.1).holds(0.0));
  CHECK_FALSE(relative(0, 0.1).holds(1e-300));
}

TEST_CASE("An absolute cell holds up to its edge; zero means equal", "[experiment]") {
  for (const double inside : {22.0, 23.0, 24.0}) CHECK(absolute(23, 1).holds(inside));
  for (const double outside : {21.999, 24.001, kNan}) CHECK_FALSE(absolute(23, 1).holds(outside));
  CHECK(absolute(23, 0).holds(23.0));
  CHECK_FALSE(absolute(23, 0).holds(22.0));
}

TEST_CASE("A cell needs exactly one tolerance", "[experiment]") {
  PublishedCell both = relative(1, 0.1);
  both.absolute = 1.0;
  for (const PublishedCell& bad : {cell(1), both}) {
    CHECK(bad.problem() == "a cell needs exactly one of rounded: true, relative and absolute");
  }
  for (const PublishedCell& good : {rounded(1), relative(1, 0), absolute(1, 0)}) CHECK(good.problem().empty());
  const io_examples::Folder folder;
  write_file(folder.path() / "t.yaml",
             "name: T\nsource: s\ncells:\n  - {experiment: e, controller: c, metric: m, value: 1, absolute: -1}\n");
  CHECK_THAT(io_examples::error_of([&] { read_published(folder.path() / "t.yaml"); }),
             Catch::EndsWith("t.yaml:4:67: absolute = -1, must be a number of at least 0"));
}

TEST_CASE("Tolerances are said in words", "[experiment]") {
  CHECK(rounded(1).tolerance_text() == "rounded");
  CHECK(relative(1, 0.15).tolerance_text() == "within 15 %");
  CHECK(absolute(1, 0).tolerance_text() == "exact");
  CHECK(absolute(1, 2).tolerance_text() == "within 2");
}

TEST_CASE("A cell without a result from a run that succeeded is missing, and a missing cell is violated",
          "[experiment]") {
  const PublishedCell wanted = relative(100, 0.1);
  CHECK(verdict(row("e", "c", "ok", 100), wanted) == "yes");
  CHECK(verdict(row("e", "c", "ok", 120), wanted) == "no");
  CHECK(verdict(row("other", "c", "ok", 100), wanted) == "missing");
  CHECK(verdict(row("e", "other", "ok", 100), wanted) == "missing");
  CHECK(verdict(row("e", "c", "failed", 100), wanted) == "missing");
  CHECK(verdict(row("e", "c", "ok", kNan), wanted) == "missing");
  CHECK(verdict(Table{}, wanted) == "missing");
  PublishedCell other = wanted;
  for (const char* metric : {"nothing", "empty", "status"}) {
    other.metric = metric;
    CHECK(verdict(row("e", "c", "ok", 100), other) == "missing");
  }
  CHECK(violations(compare(row("e", "c", "failed", 100), {"T", "s", {wanted}})) ==
        std::vector<std::string>{"e c energy: no result, published 100 (within 10 %)"});
}

TEST_CASE("Counts are compared as numbers, and of several rows the last counts", "[experiment]") {
  PublishedCell points = absolute(7, 0);
  points.metric = "points";
  CHECK(verdict(row("e", "c", "ok", 1), points) == "yes");
  Table twice = row("e", "c", "ok", 100);
  append(twice, row("e", "c", "ok", 200));
  CHECK(verdict(twice, relative(100, 0.1)) == "no");
  append(twice, row("e", "c", "failed", 100));
  CHECK(verdict(twice, relative(200, 0.1)) == "missing");
}

TEST_CASE("A comparison shows every published cell beside the result, a violation names the cell", "[experiment]") {
  const Table table = compare(row("e", "c", "ok", 120), {"T", "s", {relative(100, 0.1), rounded(120)}});
  CHECK(column_names(table) == std::vector<std::string>{"experiment", "controller", "metric", "result", "published",
                                                        "deviation_percent", "tolerance", "ok"});
  CHECK(column_texts(table, "ok") == std::vector<std::string>{"no", "yes"});
  CHECK(numbers(table, "deviation_percent", "")[0] == Approx(20.0).epsilon(1e-12));
  CHECK(violations(table) == std::vector<std::string>{"e c energy: 120, published 100 (within 10 %)"});
}
