#include "io/schema.hpp"

#include <catch2/catch.hpp>

#include "io/describe.hpp"
#include "io/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;
using nlohmann::ordered_json;

namespace {

ordered_json property(const char* name) { return schema<Study>()["properties"][name]; }

/// A second family, whose definition must not take the first one's name.
struct Twin {
  std::variant<Empty> form;
};
struct TwoFamilies {
  struct Left {
    Machine part;
    static void fields(auto& self, auto&& field) { field("part", self.part, {}); }
  } left;
  struct Right {
    Twin part;
    static void fields(auto& self, auto&& field) { field("part", self.part, {}); }
  } right;
  static void fields(auto& self, auto&& field) {
    field("left", self.left, {});
    field("right", self.right, {});
  }
};

}  // namespace

TEST_CASE("a schema has the ranges, units and defaults of the fields", "[io]") {
  const ordered_json expected = ordered_json::parse(R"json({
    "$schema": "https://json-schema.org/draft/2020-12/schema",
    "type": "object",
    "additionalProperties": false,
    "properties": {
      "length": {"type": "number", "exclusiveMinimum": 0.0, "description": "pivot to centre of mass (m)", "default": 1.0},
      "length_scales": {
        "anyOf": [
          {"type": "array", "items": {"anyOf": [{"type": "number", "exclusiveMinimum": 0.0}, {"const": ".inf"}]}},
          {"anyOf": [{"type": "number", "exclusiveMinimum": 0.0}, {"const": ".inf"}]}],
        "description": "one per input", "default": [1.0, 1.0]}},
    "required": [],
    "description": "a rod"})json");
  CHECK(schema<Rod>() == expected);
  CHECK(property("mode") == ordered_json::parse(R"({"enum": ["fast", "careful"], "default": "fast"})"));
  CHECK(property("seed") == ordered_json::parse(R"({"type": "integer", "minimum": 0.0, "default": 1})"));
  CHECK(property("limit")["anyOf"][1] == ordered_json::parse(R"({"type": "null"})"));
  CHECK(property("limit")["default"] == nullptr);
  CHECK(property("duration") ==
        ordered_json::parse(R"({"type": "string", "description": "a time such as 3 s", "default": "1 s"})"));
  CHECK(property("weights")["additionalProperties"] == ordered_json::parse(R"({"type": "number", "minimum": 0.0})"));
}

TEST_CASE("alternatives are told apart by a constant type", "[io]") {
  const ordered_json choices = property("reserve")["oneOf"];
  REQUIRE(choices.size() == 2);
  CHECK(choices[0]["properties"]["type"] == ordered_json::parse(R"({"const": "cart"})"));
  CHECK(choices[0]["required"] == ordered_json::parse(R"(["type", "mass"])"));
  CHECK(choices[1]["required"] == ordered_json::parse(R"(["type"])"));
}

TEST_CASE("a family that contains itself is defined once", "[io]") {
  const ordered_json result = schema<Study>();
  CHECK(result["properties"]["machine"] == ordered_json::parse(R"({"$ref": "#/$defs/machine"})"));
  REQUIRE(result["$defs"].size() == 1);
  const ordered_json& chain = result["$defs"]["machine"]["oneOf"][3];
  CHECK(chain["properties"]["links"]["items"] == ordered_json::parse(R"({"$ref": "#/$defs/machine"})"));
  CHECK(schema<Machine>()["$ref"] == "#/$defs/root");
}

TEST_CASE("two families under the same key have two definitions", "[io]") {
  const ordered_json result = schema<TwoFamilies>();
  CHECK(result["properties"]["left"]["properties"]["part"]["$ref"] == "#/$defs/part");
  CHECK(result["properties"]["right"]["properties"]["part"]["$ref"] == "#/$defs/part2");
  CHECK(result["$defs"]["part2"]["oneOf"].size() == 1);
}

TEST_CASE("parameters are described for people", "[io]") {
  const std::vector<ParameterDescription> list = describe<Study>();
  const auto line = [&](std::string_view name) {
    for (const ParameterDescription& p : list) {
      if (p.name == name) return p.range + " | " + p.unit + " | " + p.default_value + " | " + p.text;
    }
    return std::string("none");
  };
  CHECK(list.size() == 17);
  CHECK(list.front().name == "title");
  CHECK(line("title") == "a text |  | untitled | shown above plots");
  CHECK(line("machine") == "one of the types: rod, cart, empty, chain |  | rod | ");
  CHECK(line("reserve") == "one of the types: cart, rod |  | rod | ");
  CHECK(line("sensor") == "none");
  CHECK(line("sensor.noise") == "a number of at least 0 | rad | 0.1 | standard deviation");
  CHECK(line("mode") == "one of: fast, careful |  | fast | ");
  CHECK(line("seed") == "a whole number of at least 0 |  | 1 | ");
  CHECK(line("steps") == "a whole number of at least 1 |  | 100 | of control");
  CHECK(line("record") == "true or false |  | true | ");
  CHECK(line("limit") == "a number greater than 0, or null | N m | null | of the torque");
  CHECK(line("gains") == "a list, each a number greater than 0 |  | [1] | ");
  CHECK(line("sensors") == "a map of free names, each a map |  | {} | ");
  CHECK(line("duration") == "a time such as 3 s |  | \"1 s\" | ");
  const ParameterDescription mass = describe<Cart>().front();
  CHECK(mass.required);
  CHECK(mass.default_value.empty());
}
