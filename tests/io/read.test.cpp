#include "io/read.hpp"

#include <catch2/catch.hpp>

#include "io/examples.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;

TEST_CASE("an empty map leaves every default", "[io]") { CHECK(read_text<Study>("{}") == Study{}); }

TEST_CASE("every kind of field is read", "[io]") {
  const auto study = read_text<Study>(R"(
title: 010
machine:
  type: chain
  links:
    - {type: cart, mass: 2}
    - {type: rod, length: .5, length_scales: [.inf, 1e-3]}
    - {type: empty}
reserve: {type: cart, mass: 1}
sensor: {noise: 0}
mode: careful
seed: 18446744073709551615
steps: +7
offset: -1.5
record: false
limit: 3
gains: 2.5
tags: [a, "1"]
counts: [0, 1]
sensors: {left: {bits: 8}, right: {}}
weights: {b: 1, a: 2}
duration: 5 s
)");
  Study expected;
  expected.title = "010";
  expected.machine.form =
      Chain{{{Cart{.mass = 2.0}}, {Rod{.length = 0.5, .length_scales = {kInfinity, 1e-3}}}, {Empty{}}}};
  expected.reserve = Cart{.mass = 1.0};
  expected.sensor.noise = 0.0;
  expected.mode = Mode::careful;
  expected.seed = 18446744073709551615ULL;
  expected.steps = 7;
  expected.offset = -1.5;
  expected.record = false;
  expected.limit = 3.0;
  expected.gains = {2.5};
  expected.tags = {"a", "1"};
  expected.counts = {0, 1};
  expected.sensors.items = {{"left", {.bits = 8}}, {"right", {}}};
  expected.weights.items = {{"b", 1.0}, {"a", 2.0}};
  expected.duration.seconds = 5;
  CHECK(study == expected);
}

TEST_CASE("reading into a value keeps what is not given", "[io]") {
  Study study;
  study.steps = 5;
  study.limit = 2.0;
  read_into(parse_yaml("sensor: {bits: 3}", "f"), study);
  CHECK(study.steps == 5);
  CHECK(study.limit == 2.0);
  CHECK(study.sensor == Sensor{.bits = 3});
  read_into(parse_yaml("limit: null", "f"), study);
  CHECK_FALSE(study.limit);
}

TEST_CASE("unknown keys are refused at the key, with what was meant", "[io]") {
  CHECK(read_error<Rod>("length: 1\nlenght_scales: 2\n") ==
        "exp1.yaml:2:1: rod has no 'lenght_scales', did you mean 'length_scales'?");
  CHECK(read_error<Rod>("colour: red\n") == "exp1.yaml:1:1: rod has no 'colour', allowed: length, length_scales");
  CHECK(read_error<Study>("machine:\n  type: rod\n  lenght: 1\n") ==
        "exp1.yaml:3:3: rod has no 'lenght', did you mean 'length'?");
  CHECK(read_error<Study>("sensor: {nose: 1}") == "exp1.yaml:1:10: sensor has no 'nose', did you mean 'noise'?");
  CHECK(read_error<Sensor>("nose: 1") == "exp1.yaml:1:1: the spec has no 'nose', did you mean 'noise'?");
  CHECK(read_error<Study>("sensors: {left: {bit: 1}}") == "exp1.yaml:1:18: left has no 'bit', did you mean 'bits'?");
  CHECK(read_error<Empty>("x: 1") == "exp1.yaml:1:1: empty has no 'x', it has no parameters");
  CHECK(read_error<Rod>("type: rod") == "exp1.yaml:1:1: rod has no 'type', allowed: length, length_scales");
}

TEST_CASE("a missing key is named with its meaning", "[io]") {
  CHECK(read_error<Cart>("spring: 1") == "exp1.yaml:1:1: cart needs 'mass': of the cart (kg)");
  CHECK(read_error<Study>("a: 1\nmachine:\n  type: chain\n") != "nothing thrown");
  CHECK(read_error<Study>("machine:\n  type: chain\n") == "exp1.yaml:2:3: chain needs 'links': machines");
  CHECK(read_error<Cart>("mas: 1") == "exp1.yaml:1:1: cart has no 'mas', did you mean 'mass'?");
}

TEST_CASE("a type is chosen by name", "[io]") {
  const std::string allowed = "allowed: rod, cart, empty, chain";
  CHECK(read_error<Study>("machine: {length: 1}") == "exp1.yaml:1:10: machine needs 'type', " + allowed);
  CHECK(read_error<Study>("machine: {type: crat}") == "exp1.yaml:1:17: type = 'crat', did you mean 'cart'?");
  CHECK(read_error<Study>("machine: {type: submarine}") == "exp1.yaml:1:17: type = 'submarine', " + allowed);
  CHECK(read_error<Study>("machine: {type: [rod]}") == "exp1.yaml:1:17: type is a list, must be a word, " + allowed);
  CHECK(read_error<Study>("machine: rod") ==
        "exp1.yaml:1:10: machine = rod, must be a map with the key 'type', " + allowed);
  CHECK(read_error<Machine>("[]") ==
        "exp1.yaml:1:1: the spec is a list, must be a map with the key 'type', " + allowed);
  CHECK(read_error<Study>("mode: fats") == "exp1.yaml:1:7: mode = 'fats', did you mean 'fast'?");
  CHECK(read_error<Study>("mode: sleepy") == "exp1.yaml:1:7: mode = 'sleepy', allowed: fast, careful");
  CHECK(read_error<Study>("mode:") == "exp1.yaml:1:1: mode has no value, must be a word, allowed: fast, careful");
}

TEST_CASE("numbers outside their range are refused with the range", "[io]") {
  const std::string must = ", must be a number greater than 0 (m)";
  CHECK(read_error<Rod>("length: -1") == "exp1.yaml:1:9: length = -1" + must);
  CHECK(read_error<Rod>("length: 0") == "exp1.yaml:1:9: length = 0" + must);
  CHECK(read_text<Rod>("length: 5e-324").length == 5e-324);
  CHECK(read_text<Cart>("{mass: 1, spring: 0.2}").spring == 0.2);
  CHECK(read_text<Cart>("{mass: 1, spring: 5}").spring == 5.0);
  CHECK(read_error<Cart>("{mass: 1, spring: 5.000001}") ==
        "exp1.yaml:1:19: spring = 5.000001, must be a number from 0.2 to 5 (N/m)");
  CHECK(read_error<Rod>("length_scales: [1, 0]") ==
        "exp1.yaml:1:20: length_scales[1] = 0, must be a number greater than 0 or .inf");
  CHECK(read_error<Study>("weights: {a: -1}") == "exp1.yaml:1:14: a = -1, must be a number of at least 0");
  CHECK(read_error<Study>("limit: 0") == "exp1.yaml:1:8: limit = 0, must be a number greater than 0 (N m)");
}

TEST_CASE("other notations of numbers are refused", "[io]") {
  const std::string must = ", must be a number greater than 0 (m)";
  const std::string decimal = must + ": written in decimal without leading zeros, such as 10, -0.5 or 1e-3";
  for (const std::string text : {"010", "0x10", "1_000", "1.5m", "-010", "1:30"}) {
    CHECK(read_error<Rod>("length: " + text) == "exp1.yaml:1:9: length = " + text + decimal);
  }
  for (const std::string text : {"1e400", "1e-400"}) {
    CHECK(read_error<Rod>("length: " + text) ==
          "exp1.yaml:1:9: length = " + text + must + ": beyond what 64 bits can hold");
  }
  for (const std::string text : {".nan", "nan", "inf", "abc", ".Inf"}) {
    CHECK(read_error<Rod>("length: " + text) == "exp1.yaml:1:9: length = " + text + must);
  }
  CHECK(read_error<Rod>("length: .inf") == "exp1.yaml:1:9: length = .inf" + must + ": .inf is not admitted here");
  CHECK(read_error<Rod>("length_scales: -.inf") ==
        "exp1.yaml:1:16: length_scales = -.inf, must be a number greater than 0 or .inf: -.inf is not admitted here");
  CHECK(read_error<Rod>("length: \"1\"") == "exp1.yaml:1:9: length = \"1\"" + must + ": in quotes it is a text");
  CHECK(read_error<Rod>("length:") == "exp1.yaml:1:1: length has no value" + must);
  CHECK(read_error<Rod>("length: {a: 1}") == "exp1.yaml:1:9: length is a map" + must);
  CHECK(read_error<Rod>("length: [1]") == "exp1.yaml:1:9: length is a list" + must);
}

TEST_CASE("whole numbers are whole and fit their type", "[io]") {
  const std::string must = ", must be a whole number of at least 1";
  CHECK(read_error<Study>("steps: 0") == "exp1.yaml:1:8: steps = 0" + must);
  CHECK(read_error<Study>("steps: 1.5") == "exp1.yaml:1:8: steps = 1.5" + must);
  CHECK(read_error<Study>("steps: 1e3") == "exp1.yaml:1:8: steps = 1e3" + must);
  CHECK(read_text<Study>("steps: 2147483647").steps == 2147483647);
  CHECK(read_error<Study>("steps: 2147483648") == "exp1.yaml:1:8: steps = 2147483648" + must + ", at most 2147483647");
  CHECK(read_error<Study>("steps: -99999999999") == "exp1.yaml:1:8: steps = -99999999999" + must);
  CHECK(read_error<Study>("seed: -1") == "exp1.yaml:1:7: seed = -1, must be a whole number of at least 0");
  CHECK(
      read_error<Study>("seed: 18446744073709551616") ==
      "exp1.yaml:1:7: seed = 18446744073709551616, must be a whole number of at least 0, at most 18446744073709551615");
  CHECK(read_error<Study>("seed: \"1\"") ==
        "exp1.yaml:1:7: seed = \"1\", must be a whole number of at least 0: in quotes it is a text");
  CHECK(read_error<Study>("steps: 010") ==
        "exp1.yaml:1:8: steps = 010" + must + ": written in decimal without leading zeros, such as 10, -0.5 or 1e-3");
}

TEST_CASE("values of the wrong kind are refused", "[io]") {
  for (const std::string text : {"yes", "True", "1"}) {
    CHECK(read_error<Study>("record: " + text) == "exp1.yaml:1:9: record = " + text + ", must be true or false");
  }
  CHECK(read_error<Study>("record: 'true'") == "exp1.yaml:1:9: record = \"true\", must be true or false");
  CHECK(read_error<Study>("title: [a]") == "exp1.yaml:1:8: title is a list, must be a text");
  CHECK(read_error<Study>("title: null") == "exp1.yaml:1:1: title has no value, must be a text");
  CHECK(read_error<Study>("sensor: 3") == "exp1.yaml:1:9: sensor = 3, must be a map");
  CHECK(read_error<Study>("sensor:") == "exp1.yaml:1:1: sensor has no value, must be a map");
  CHECK(read_error<Study>("tags: a") == "exp1.yaml:1:7: tags = a, must be a list");
  CHECK(read_error<Study>("counts: 1") == "exp1.yaml:1:9: counts = 1, must be a list");
  CHECK(read_error<Study>("gains: {a: 1}") == "exp1.yaml:1:8: gains is a map, must be a list");
  CHECK(read_error<Study>("sensors: [a]") == "exp1.yaml:1:10: sensors is a list, must be a map");
  CHECK(read_error<Study>("weights: {\"\": 1}") == "exp1.yaml:1:11: a name in weights is empty");
  CHECK(read_error<Study>("- 1") == "exp1.yaml:1:1: the spec is a list, must be a map");
  CHECK(read_error<Study>("title: ~\n") == "exp1.yaml:1:1: title has no value, must be a text");
}

TEST_CASE("a constraint over several fields is reported at the map", "[io]") {
  CHECK(read_error<Cart>("mass: 500\nspring: 1\n") == "exp1.yaml:1:1: cart is too heavy for its spring");
  CHECK(read_error<Study>("machine:\n  type: chain\n  links: []\n") ==
        "exp1.yaml:2:3: chain needs at least one machine in links");
}

TEST_CASE("a type may bring its own notation", "[io]") {
  CHECK(read_text<Study>("duration: 12 s").duration.seconds == 12);
  CHECK(read_error<Study>("duration: 12") == "exp1.yaml:1:11: write it as '3 s'");
}
