#include "io/emit.hpp"

#include <catch2/catch.hpp>
#include <limits>

#include "base/random.hpp"
#include "io/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;
using nlohmann::ordered_json;

namespace {

/// What a text becomes as a value and as a key, written and read again.
struct Texts {
  std::vector<std::string> list;
  Named<double> keys;
  static void fields(auto& self, auto&& field) {
    field("list", self.list, {});
    field("keys", self.keys, {kAny, "", ""});
  }
  bool operator==(const Texts&) const = default;
};

template <class T>
T round_trip(const T& value) {
  return read<T>(parse_yaml(to_yaml(to_json(value)), "round trip"));
}

Study rich_study() {
  Study study;
  study.title = "a: b # c";
  study.machine.form = Chain{{{Cart{.mass = 2.0}}, {Chain{{{Rod{.length_scales = {kInfinity, 0.1}}}, {Empty{}}}}}}};
  study.reserve = Cart{.mass = 1e-300};
  study.mode = Mode::careful;
  study.seed = 18446744073709551615ULL;
  study.limit = 0.1 + 0.2;
  study.gains = {1e300, 5e-324, 100000.0, 1.0 / 3.0};
  study.tags = {"true", "010", "", "x"};
  study.counts = {0, 2147483647};
  study.sensors.items = {{"b", {.bits = 1}}, {"a", {}}, {"null", {}}, {"1", {}}};
  study.duration.seconds = 9;
  return study;
}

}  // namespace

TEST_CASE("the resolved value shows every default in order", "[io]") {
  Study study;
  study.machine.form = Cart{.mass = 2.0};
  CHECK(
      to_json(study).dump() ==
      R"({"title":"untitled","machine":{"type":"cart","mass":2.0,"spring":2.0},)"
      R"("reserve":{"type":"rod","length":1.0,"length_scales":[1.0,1.0]},"sensor":{"noise":0.1,"bits":12},)"
      R"("mode":"fast","seed":1,"steps":100,"offset":0.0,"record":true,"limit":null,"gains":[1.0],"tags":[],"counts":[],)"
      R"("sensors":{},"weights":{},"duration":"1 s"})");
}

TEST_CASE("JSON has texts for infinities and null for NaN", "[io]") {
  CHECK(to_json(std::vector<double>{kInfinity, -kInfinity, std::numeric_limits<double>::quiet_NaN(), 0.1}).dump() ==
        R"([".inf","-.inf",null,0.1])");
}

TEST_CASE("YAML stands in block style, plain lists in one line", "[io]") {
  Study study = rich_study();
  study.gains = {1e-5, 2.5};
  CHECK(to_yaml(to_json(study)) == R"(title: "a: b # c"
machine:
  type: chain
  links:
    - type: cart
      mass: 2
      spring: 2
    - type: chain
      links:
        - type: rod
          length: 1
          length_scales: [.inf, 0.1]
        - type: empty
reserve:
  type: cart
  mass: 1.0e-300
  spring: 2
sensor:
  noise: 0.1
  bits: 12
mode: careful
seed: 18446744073709551615
steps: 100
offset: 0
record: true
limit: 0.30000000000000004
gains: [1.0e-05, 2.5]
tags: ["true", "010", "", x]
counts: [0, 2147483647]
sensors:
  b:
    noise: 0.1
    bits: 1
  a:
    noise: 0.1
    bits: 12
  "null":
    noise: 0.1
    bits: 12
  "1":
    noise: 0.1
    bits: 12
weights: {}
duration: "9 s"
)");
  CHECK(to_yaml_line(to_json(Rod{})) == "{length: 1, length_scales: [1, 1]}");
  CHECK(to_yaml(ordered_json::parse(R"([[1, 2], [[3], {}], {"a": [], "b": {"c": null}}])")) ==
        "- [1, 2]\n- - [3]\n  - {}\n- a: []\n  b:\n    c: null\n");
}

TEST_CASE("what is written is read back the same", "[io]") {
  CHECK(round_trip(Study{}) == Study{});
  CHECK(round_trip(rich_study()) == rich_study());
  const Machine machine = rich_study().machine;
  CHECK(round_trip(machine) == machine);
}

TEST_CASE("JSON is YAML: what a result holds can be run again", "[io]") {
  CHECK(read<Study>(parse_yaml(to_json(rich_study()).dump(), "result.json")) == rich_study());
  CHECK(read<Study>(parse_yaml(to_json(rich_study()).dump(2), "result.json")) == rich_study());
}

TEST_CASE("texts survive whatever they look like", "[io]") {
  Texts texts;
  texts.list = {"true",
                "010",
                "a: b",
                "",
                "#x",
                "x #y",
                " x",
                "x ",
                "line\nbreak",
                "\n",
                "tab\t",
                "\"",
                "\\",
                "'",
                "~",
                "null",
                "Null",
                ".inf",
                "-.inf",
                ".nan",
                "1e5",
                "-",
                "- a",
                "?",
                "!x",
                "&x",
                "*x",
                "@",
                "`",
                "%",
                "{",
                "[a]",
                "a,b",
                "\xc3\xbc",
                "\xe2\x82\xac",
                "\xf0\x9f\x98\x80",
                "\xc2\x85",
                "\xc2\xa0",
                "\xe2\x80\xa8",
                "\xe2\x80\xa9",
                "\xef\xbb\xbf",
                "\x01\x04\x7f\x1b",
                std::string("a\0b", 3),
                "\r\n",
                "yes",
                "No",
                "1:30",
                "2024-01-01",
                "<<",
                "---",
                "...",
                std::string(2000, 'x'),
                "a\\n",
                "0x10",
                "|",
                ">",
                "=",
                "_",
                "a  b",
                "<script>"};
  for (const std::string& text : texts.list) {
    if (!text.empty() && text.size() < 1000) texts.keys.items.emplace_back(text, 1.0);
  }
  CHECK(round_trip(texts) == texts);
}

TEST_CASE("random texts and numbers survive", "[io]") {
  RandomStream stream(7);
  const std::vector<std::string> pieces{"a", "1", " ", "\n", ":",        "#",        "\"",           "'", "\\",
                                        "-", ".", "e", "\t", "\xc3\xbc", "\xc2\x85", "\xe2\x80\xa8", "[", "{",
                                        ",", "&", "*", "!",  "|",        "%",        "\r",           "0", "x"};
  for (int round = 0; round < 300; ++round) {
    Texts texts;
    for (int i = 0; i < 10; ++i) {
      std::string text;
      for (std::uint64_t length = stream() % 8; length > 0; --length) text += pieces[stream() % pieces.size()];
      texts.list.push_back(text);
      double number = 0.0;
      const std::uint64_t bits = stream();
      std::memcpy(&number, &bits, sizeof number);
      if (std::isfinite(number) && !text.empty() && !texts.keys.find(text)) texts.keys.items.emplace_back(text, number);
    }
    REQUIRE(round_trip(texts) == texts);
  }
}
