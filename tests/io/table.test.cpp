#include "io/table.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;
using io_examples::error_of;

namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Table mixed() {
  return {{{.name = "key", .unit = "", .cells = std::vector<Cell>{"a", "b,\"c\"\nd", ""}},
           {.name = "error", .unit = "rad", .cells = std::vector<double>{0.1, -2.5, 1e-300}},
           {.name = "steps", .unit = "", .cells = std::vector<Cell>{std::int64_t{7}, Cell{}, std::int64_t{-1}}},
           {.name = "note", .unit = "", .cells = std::vector<Cell>{"010", "nan", Cell{}}}}};
}

Table without_units(Table table) {
  for (Column& column : table.columns) column.unit.clear();
  return table;
}

std::string csv_error(std::string_view text) {
  return error_of<DataError>([&] { parse_csv(text, "runs.csv"); });
}

}  // namespace

TEST_CASE("CSV follows RFC 4180 and keeps texts apart from numbers", "[io]") {
  CHECK(to_csv(mixed()) == "key,error,steps,note\na,0.1,7,010\n\"b,\"\"c\"\"\nd\",-2.5,,\"nan\"\n\"\",1e-300,-1,\n");
  CHECK(to_csv({{{.name = "x", .cells = std::vector<double>{1.0 / 3.0, kInfinity, -kNan}}}}, 3) ==
        "x\n0.333\ninf\nnan\n");
  CHECK(to_csv({{{.name = "n", .cells = std::vector<Cell>{"1", "1e5", "-inf", "x\r"}}}}) ==
        "n\n\"1\"\n\"1e5\"\n\"-inf\"\n\"x\r\"\n");
  CHECK(to_csv({}).empty());
}

TEST_CASE("a table is read back as it was written", "[io]") {
  CHECK(parse_csv(to_csv(mixed()), "f") == without_units(mixed()));
  const Table missing{{{.name = "x", .cells = std::vector<Cell>{Cell{}, 1.5, Cell{}}}}};
  CHECK(parse_csv(to_csv(missing), "f") == missing);
  const Table none{{{.name = "x", .cells = std::vector<Cell>{}}, {.name = "1", .cells = std::vector<Cell>{}}}};
  CHECK(parse_csv(to_csv(none), "f") == none);
  const std::vector<double> values{0.1, 1e5, -0.0, 5e-324, 1.7976931348623157e308, kInfinity, 123456789.0};
  const Table numeric = parse_csv(to_csv({{{.name = "x", .cells = values}}}), "f");
  CHECK(std::get<std::vector<double>>(numeric.columns[0].cells) == values);
  CHECK(std::signbit(std::get<std::vector<double>>(numeric.columns[0].cells)[2]));
  for (const Table& table : {mixed(), missing, numeric}) CHECK(to_csv(parse_csv(to_csv(table), "f")) == to_csv(table));
}

TEST_CASE("CSV with CRLF, a byte-order mark or an unfinished last line is read", "[io]") {
  const Table expected{{{.name = "a", .cells = std::vector<Cell>{std::int64_t{1}, std::int64_t{3}}},
                        {.name = "b", .cells = std::vector<Cell>{"x", "y"}}}};
  CHECK(parse_csv("a,b\n1,x\n3,y\n", "f") == expected);
  CHECK(parse_csv("\xef\xbb\xbf"
                  "a,b\r\n1,x\r\n3,\"y\"\r\n",
                  "f") == expected);
  CHECK(parse_csv("a,b\n1,x\n3,y", "f") == expected);
}

TEST_CASE("a CSV file that cannot be ours is refused with its line", "[io]") {
  CHECK(csv_error("") == "runs.csv: is empty");
  CHECK(csv_error("a,b\n1,2\n3\n") == "runs.csv:3: has 1 cells, the header 2");
  CHECK(csv_error("a,b\n1,\"x\ny\"\n3,4,5\n") == "runs.csv:4: has 3 cells, the header 2");
  CHECK(csv_error("a,b\n1,2\n\n3,4\n") == "runs.csv:3: has 1 cells, the header 2");
  CHECK(csv_error("a,b,a\n") == "runs.csv:1: column 'a' is repeated");
  CHECK(csv_error("a,,b\n") == "runs.csv:1: the header must give each column a name");
  CHECK(csv_error("a\n\"x\n\ny") == "runs.csv:2: this quote is never closed");
  CHECK(csv_error("a\nx\"y\"\n") == "runs.csv:2: a quote inside 'x\"y\"'");
  CHECK(csv_error("a\n\"x\"y\n") == "runs.csv:2: expected ',' or the end of the line after \"");
}

TEST_CASE("a table file is read from disk", "[io]") {
  const io_examples::Folder folder;
  write_file(folder.path() / "t.csv", to_csv(mixed()));
  CHECK(read_csv(folder.path() / "t.csv") == without_units(mixed()));
  CHECK_THROWS_AS(read_csv(folder.path() / "absent.csv"), IoError);
}

TEST_CASE("appending takes the union of the columns", "[io]") {
  Table table{{{.name = "a", .unit = "", .cells = std::vector<double>{1.0, 2.0}},
               {.name = "b", .unit = "m", .cells = std::vector<double>{3.0, 4.0}}}};
  append(table, {{{.name = "c", .unit = "", .cells = std::vector<Cell>{"x"}},
                  {.name = "a", .unit = "s", .cells = std::vector<double>{5.0}}}});
  CHECK(to_csv(table) == "a,b,c\n1,3,\n2,4,\n5,,x\n");
  CHECK(std::holds_alternative<std::vector<double>>(table.columns[0].cells));
  CHECK(table.columns[0].unit == "s");
  Table empty;
  append(empty, table);
  CHECK(empty == table);
  append(empty, {});
  CHECK(empty == table);
  CHECK_THROWS_WITH(append(table, {{{.name = "b", .unit = "mm", .cells = std::vector<double>{1.0}}}}),
                    "column 'b' is in m and in mm");
  CHECK(table == empty);  // untouched
}

TEST_CASE("columns of unequal length are a mistake of the caller", "[io]") {
  const Table ragged{{{.name = "a", .cells = std::vector<double>{1.0}}, {.name = "b", .cells = std::vector<double>{}}}};
  CHECK_THROWS_AS(to_csv(ragged), std::invalid_argument);
  CHECK_THROWS_WITH(ragged.rows(), "column 'b' differs in length from 'a'");
}

TEST_CASE("Markdown has units, rounded numbers and no markup from cells", "[io]") {
  const Table table{{{.name = "a_b", .unit = "", .cells = std::vector<Cell>{"x|y", "<b>&\n"}},
                     {.name = "error", .unit = "rad", .cells = std::vector<double>{0.12345, 1e-9}},
                     {.name = "n", .unit = "", .cells = std::vector<Cell>{std::int64_t{1234567}, Cell{}}}}};
  CHECK(
      to_markdown(table, 3) ==
      "| a\\_b | error (rad) | n |\n| --- | ---: | ---: |\n| x\\|y | 0.123 | 1234567 |\n| &lt;b>&amp;  | 1e-09 | |\n");
}

TEST_CASE("JSON has one object per row", "[io]") {
  CHECK(to_json(Table{{{.name = "x", .cells = std::vector<double>{0.5, kNan}},
                       {.name = "y", .cells = std::vector<Cell>{Cell{}, "t"}}}})
            .dump() == R"([{"x":0.5,"y":null},{"x":null,"y":"t"}])");
}

TEST_CASE("A terminal gets aligned columns, numbers to the right, units below the names, each row one line", "[io]") {
  const Table table{{{"name", "", std::vector<Cell>{std::string("a"), std::string("two\nlines")}},
                     {"energy", "J", std::vector<double>{1.5, 1234.5678}}}};
  CHECK(to_text(table, 5) ==
        "name       energy\n"
        "                J\n"
        "a             1.5\n"
        "two lines  1234.6\n");
}

TEST_CASE("numbers are taken from a column or refused", "[io]") {
  const Table table = parse_csv("q1,n,s\n0.5,1,x\n1,,2\n", "rec.csv");
  CHECK(numbers(table, "q1", "rec.csv") == std::vector<double>{0.5, 1.0});
  const std::vector<double> n = numbers(table, "n", "rec.csv");
  CHECK(n[0] == 1.0);
  CHECK(std::isnan(n[1]));
  CHECK(error_of<DataError>([&] { numbers(table, "s", "rec.csv"); }) ==
        "rec.csv: column 's', row 1: 'x' must be a number");
  CHECK(error_of<DataError>([&] { numbers(table, "q2", "rec.csv"); }) ==
        "rec.csv: has no column 'q2', did you mean 'q1'?");
}
