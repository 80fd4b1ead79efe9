#include <catch2/catch.hpp>

#include "diagnose/recording/data_table.hpp"
#include "diagnose/recording/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::recording_examples;

TEST_CASE("Every notation of the same table of numbers reads the same", "[diagnose]") {
  const DataTable plain = parse("t,q,u\n0,1.5,-2\n0.25,1e-3,+4\n");
  REQUIRE(plain.names == Names{"t", "q", "u"});
  REQUIRE(plain.columns == std::vector<Column>{{0, 0.25}, {1.5, 1e-3}, {-2, 4}});
  CHECK(plain.lines == std::vector<int>{2, 3});
  for (const std::string text : {
           "\xEF\xBB\xBFt,q,u\n0,1.5,-2\n0.25,1e-3,+4\n",         // byte-order mark
           "t,q,u\n0,1.5,-2\n0.25,1e-3,+4",                       // no last line end
           "t,q,u\r\n0,1.5,-2\r\n0.25,1e-3,+4\r\n",               // lines of Windows
           "t;q;u\n0;1,5;-2\n0,25;1e-3;+4\n",                     // decimal commas
           "t;q;u\n0;1.5;-2\n0.25;1e-3;+4\n",                     // semicolons
           "t\tq\tu\n0\t1.5\t-2\n0.25\t1e-3\t+4\n",               // tabs
           " t , q ,\tu \n 0 , 1.5, -2\n0.25 ,1e-3,  +4  \n",     // blanks
           "t,q,u,\n0,1.5,-2,\n0.25,1e-3,+4,\n",                  // a separator at the end of all rows,
           "t,q,u,\n0,1.5,-2\n0.25,1e-3,+4\n",                    // of the header,
           "t,q,u\n0,1.5,-2,\n0.25,1e-3,+4\n",                    // of one row
           "\"t\",\"q\",\"u\"\n\"0\",\"1.5\",-2\n0.25,1e-3,+4\n"  // quotes
       }) {
    INFO(text);
    const DataTable table = parse(text);
    CHECK(table.names == plain.names);
    CHECK(table.columns == plain.columns);
    CHECK(table.lines == plain.lines);
  }
}

TEST_CASE("Comments and empty lines count as lines of the file but are no rows", "[diagnose]") {
  const DataTable table = parse("# measured, on Monday\n\nt,q\n0,1\n  # a pause\n\n1,2\n");
  CHECK(table.columns == std::vector<Column>{{0, 1}, {1, 2}});
  CHECK(table.lines == std::vector<int>{4, 7});
}

TEST_CASE("A quoted name may hold the separator, a cell that is no number is NaN", "[diagnose]") {
  const DataTable table = parse("\"angle, left\",\"u\"\n1,on\n,2\n");
  CHECK(table.names == Names{"angle, left", "u"});
  CHECK(table.columns[0][0] == 1.0);
  CHECK(std::isnan(table.columns[0][1]));
  CHECK(std::isnan(table.columns[1][0]));
  CHECK(table.columns[1][1] == 2.0);
}

TEST_CASE("A first row of numbers is data, and its columns have numbers for names", "[diagnose]") {
  const DataTable table = parse("# run\n0,1\n2,3\n");
  CHECK(table.names == Names{"1", "2"});
  CHECK(table.columns == std::vector<Column>{{0, 2}, {1, 3}});
  CHECK(table.lines == std::vector<int>{2, 3});
  CHECK(parse("0;1,5;\n").columns == std::vector<Column>{{0}, {1.5}});
  CHECK(parse("1,2\n0,5\n").columns == std::vector<Column>{{0}, {5}});  // a header of numbers
}

TEST_CASE("Names of columns are UTF-8, also where the file is Latin-1", "[diagnose]") {
  CHECK(parse("t,angle [\xb0]\n0,1\n").names == Names{"t", "angle [\xc2\xb0]"});
  CHECK(parse("t,angle [\xc2\xb0]\n0,1\n").names == Names{"t", "angle [\xc2\xb0]"});
  CHECK(parse_error("\xfc,\xfc\n0,1\n") == "run.csv:1: two columns are named '\xc3\xbc'");
}

TEST_CASE("Of a long table pieces are kept, evenly spread, and the rest is counted", "[diagnose]") {
  for (const std::size_t rows :
       {std::size_t{1}, std::size_t{63}, std::size_t{64}, std::size_t{65}, std::size_t{1000}, std::size_t{4097}}) {
    for (const std::size_t pieces : {std::size_t{4}, std::size_t{8}}) {
      CAPTURE(rows, pieces);
      const std::size_t most = 64, length = most / pieces;
      const DataTable table = parse_data_csv(example_csv(static_cast<int>(rows)), "run.csv",
                                             {.columns = {"t", "u"}, .numbers = 2 * most, .pieces = pieces});
      const std::vector<std::size_t>& kept = table.rows;
      REQUIRE(!kept.empty());
      CHECK(kept.size() + table.left_out == rows);
      CHECK(kept.size() <= most);
      CHECK(kept.size() >= std::min(rows, most / 2 - length));
      CHECK(table.columns[1].empty());
      const std::size_t every = rows <= most ? 1 : kept[length] / length;  // begins a piece
      for (std::size_t i = 0; i < kept.size(); ++i) {
        REQUIRE(kept[i] == i / length * every * length + i % length);
        REQUIRE(table.columns[0][i] == Approx(0.1 * static_cast<double>(kept[i])));
        REQUIRE(table.columns[2][i] == -static_cast<double>(kept[i]));
        REQUIRE(table.lines[i] == static_cast<int>(kept[i]) + 2);
      }
      CHECK(rows - kept.back() <= every * length);  // up to its end
    }
  }
}

TEST_CASE("What lies outside of from and to is none of a long table, and stamps of a rate stay right", "[diagnose]") {
  const auto counts = [](std::size_t row, double t) { return row >= 500 && t < 80.0; };
  const DataTable table = parse_data_csv(example_csv(1000), "run.csv",
                                         {.columns = {"t", "q"}, .counts = counts, .numbers = 2 * 400, .pieces = 8});
  CHECK(table.rows.size() == 300);
  CHECK(table.left_out == 0);
  CHECK(table.rows.front() == 500);
  CHECK(table.rows.back() == 799);
}

TEST_CASE("A table that cannot be read is refused at its line", "[diagnose]") {
  CHECK(parse_error("") == "run.csv: the file is empty");
  CHECK(parse_error("\xEF\xBB\xBF\n# only a comment\n") == "run.csv: the file is empty");
  CHECK(parse_error("t,q\n# no data\n") == "run.csv: the file has a header and no rows");
  CHECK(parse_error("t,q\n0,1\n0\n") == "run.csv:3: the row has 1 cells, the header 2");
  CHECK(parse_error("t,q\n0,1\n\n1,2,3\n") == "run.csv:4: the row has 3 cells, the header 2");
  CHECK(parse_error("t,q\n0,1,,\n") == "run.csv:2: the row has 4 cells, the header 2");
  CHECK_THAT(parse_error("t,q,t\n0,1,2\n"), Catch::StartsWith("run.csv:1: two columns are named 't'"));
}
