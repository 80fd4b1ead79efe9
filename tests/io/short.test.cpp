// Types of which a plain value alone may be given, and that keep where they stand.

#include <catch2/catch.hpp>

#include "io/describe.hpp"
#include "io/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;
using nlohmann::ordered_json;

namespace {

struct Channel {
  static constexpr std::string_view kShort = "column";
  std::string column;
  double scale = 1.0;
  Location where;

  static void fields(auto& self, auto&& field) {
    field("column", self.column, {.text = "its name", .required = true});
    field("scale", self.scale, {kPositive, "", "to SI units"});
  }
};

struct Plug {
  Channel first;
  std::vector<Channel> others;

  static void fields(auto& self, auto&& field) {
    field("first", self.first, {});
    field("others", self.others, {});
  }
};

}  // namespace

TEST_CASE("a plain value stands for the field that may stand alone", "[io]") {
  for (const std::string text : {"first: q\nothers: [a, {column: b, scale: 2}]\n",
                                 "first: {column: q}\nothers: [{column: a}, {column: b, scale: 2}]\n"}) {
    const auto plug = read_text<Plug>(text);
    CHECK(plug.first.column == "q");
    REQUIRE(plug.others.size() == 2);
    CHECK(plug.others[0].column == "a");
    CHECK(plug.others[1].scale == 2.0);
  }
  CHECK(read_text<Plug>("others: a\n").others.size() == 1);
  CHECK(read_text<Plug>("others: {column: a}\n").others.size() == 1);
}

TEST_CASE("a value keeps where it stands in the file", "[io]") {
  const auto plug = read_text<Plug>("first: q\nothers:\n  - a\n  - {column: b}\n");
  CHECK(to_string(plug.first.where) == "exp1.yaml:1:8");
  CHECK(to_string(plug.others[0].where) == "exp1.yaml:3:5");
  CHECK(to_string(plug.others[1].where) == "exp1.yaml:4:5");
}

TEST_CASE("what is neither a plain value nor a map is refused", "[io]") {
  CHECK(read_error<Plug>("first: [q]\n") == "exp1.yaml:1:8: first is a list, must be a map");
  CHECK(read_error<Plug>("first: {scale: 2}\n") == "exp1.yaml:1:8: first needs 'column': its name");
  CHECK(read_error<Plug>("first: {column: q, scale: 0}\n") ==
        "exp1.yaml:1:27: scale = 0, must be a number greater than 0");
}

TEST_CASE("the schema and the description say that a value may stand alone", "[io]") {
  const ordered_json first = schema<Plug>()["properties"]["first"]["anyOf"];
  REQUIRE(first.size() == 2);
  CHECK(first[0] == ordered_json::parse(R"({"type": ["string", "number", "boolean"]})"));
  CHECK(first[1]["required"] == ordered_json::parse(R"(["column"])"));
  CHECK(describe<Channel>().size() == 2);
  CHECK(detail::range_text<std::vector<Channel>>({}) == "a list, each a map, or its column alone");
}
