#include "support/fuzz.hpp"

#include <catch2/catch.hpp>

#include "base/random.hpp"
#include "io/examples.hpp"
#include "io/table.hpp"

using namespace bayesctrl;
using namespace bayesctrl::io_examples;
using namespace bayesctrl::testing;

namespace {

const std::string kSpec = R"(# a study
title: "a \u00fc"
machine: &m
  type: chain
  links:
    - {type: cart, mass: 2}
    - type: rod
      length_scales: [.inf, 1e-3]
sensor: {noise: 0.5, bits: 8}
mode: careful
seed: 3
limit: ~
tags:
  - 'b''c'
  - !!str 1
  - |
    x
sensors:
  left: &s {bits: 8}
  right: *s
weights: {b: 1, a: 2}
)";

}  // namespace

TEST_CASE("any bytes are either read or refused", "[io]") {
  RandomStream stream(1);
  int parsed = 0;
  int read_whole = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text = i % 2 == 0 ? random_text(stream) : mutated(kSpec, stream);
    Node node;
    if (!accepted<SpecError>(text, [&] { node = parse_yaml(text, "f"); })) continue;
    ++parsed;
    Study study;
    if (!accepted<SpecError>(text, [&] { study = read<Study>(node); })) continue;
    ++read_whole;
    if (!(read<Study>(parse_yaml(to_yaml(to_json(study)), "f")) == study)) FAIL("not read back:\n" << text);
  }
  CHECK(parsed > 1000);  // the generator must reach the reader
  CHECK(read_whole > 200);
}

TEST_CASE("any override is either taken or refused", "[io]") {
  RandomStream stream(2);
  const Node spec = parse_yaml(kSpec, "f");
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text =
        i % 2 == 0 ? random_text(stream) : mutated("machine.links[1].length_scales.0={a: 1}", stream);
    taken += accepted<SpecError>(text, [&] {
      Node copy = spec;
      set_path(copy, text);
    });
  }
  CHECK(taken > 1000);
}

TEST_CASE("any CSV is either read, and then written and read the same, or refused", "[io]") {
  RandomStream stream(3);
  int taken = 0;
  for (int i = 0; i < 20'000; ++i) {
    const std::string text =
        i % 2 == 0 ? random_text(stream) : mutated("a,b\n1,x\n0.5,\"y\"\"z\"\r\n-inf,\n,\n", stream);
    Table table;
    if (!accepted<DataError>(text, [&] { table = parse_csv(text, "f"); })) continue;
    ++taken;
    const std::string again = to_csv(table);
    if (to_csv(parse_csv(again, "f")) != again) FAIL("not read back:\n" << text);
  }
  CHECK(taken > 1000);
}
