#include "diagnose/recording/spec.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

#include "diagnose/recording/read_recording.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "physics/catalogue.hpp"
#include "support/fuzz.hpp"
#include "support/text.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

const std::string kSpec = R"(name: pendulum
model:
  plant: pendulum
  parameters: {length: 0.5, mass: 2}
  free: [friction, mass]
signals:
  time: t
  position: {column: q, scale: 0.001, offset: 0.1, unit: mrad}
  input: {column: u, hold: linear}
recordings: [a.csv, {file: b.csv, from: 1, to: 9.5}]
held_out: c.csv
effects: [coulomb_friction, input_delay]
horizon_s: 0.75
)";

DiagnosisSpec read_spec_text(const std::string& text, const Folder& folder = {}) {
  write_file(folder.path() / "spec.yaml", text);
  return read_diagnosis_spec(folder.path() / "spec.yaml");
}

/// The message for a spec with one change, without the folder.
std::string error_with(const std::string& from, const std::string& to) {
  const std::string message = error_of([&] { read_spec_text(replaced(kSpec, from, to)); });
  const std::size_t name = message.find("spec.yaml");
  return name == std::string::npos ? message : message.substr(name);
}

void check_at(const std::string& place, const std::string& words, const std::string& message) {
  CHECK_THAT(message, Catch::StartsWith("spec.yaml:" + place + ": ") && Catch::Contains(words));
}

}  // namespace

TEST_CASE("A spec of a diagnosis has what the file says", "[diagnose]") {
  const Folder folder;
  const DiagnosisSpec spec = read_spec_text(kSpec, folder);
  CHECK(spec.name == "pendulum");
  REQUIRE(spec.model.plant.has_value());
  CHECK(*spec.model.plant == Plant(Pendulum{.length = 0.5, .mass = 2.0}));
  CHECK(spec.model.free == std::vector<std::string>{"friction", "mass"});
  CHECK(spec.joints() == 1);
  CHECK(spec.signals.time.column->column == "t");
  CHECK(spec.signals.position[0].column == "q");
  CHECK(spec.signals.position[0].scale == 0.001);
  CHECK(spec.signals.position[0].offset == 0.1);
  CHECK(spec.signals.position[0].unit == "mrad");
  CHECK(spec.signals.input[0].column == "u");
  CHECK(spec.signals.input[0].hold == Hold::linear);
  CHECK(spec.signals.input[0].where.line == 9);
  REQUIRE(spec.recordings.size() == 2);
  CHECK(spec.recordings[0].name == "a.csv");
  CHECK(spec.recordings[0].file == folder.path() / "a.csv");
  CHECK_FALSE(spec.recordings[0].from.has_value());
  CHECK(spec.recordings[1].from == 1.0);
  CHECK(spec.recordings[1].to == 9.5);
  REQUIRE(spec.held_out.size() == 1);
  CHECK(spec.held_out[0].file == folder.path() / "c.csv");
  const std::vector<std::string_view> names = effect_names();
  REQUIRE(spec.effects.size() == 2);
  CHECK(names[spec.effects[0]] == "coulomb_friction");
  CHECK(names[spec.effects[1]] == "input_delay");
  CHECK(spec.horizon == 0.75);
}

TEST_CASE("A spec of a diagnosis and its recording in one folder are read from anywhere", "[diagnose]") {
  const Folder folder;
  std::string csv = "t,q,u\n";
  for (int k = 0; k < 10; ++k) csv += std::to_string(k) + ",1000,2\n";
  write_file(folder.path() / "a.csv", csv);
  const DiagnosisSpec spec = read_spec_text(kSpec, folder);
  const Measured found = read_recording(spec.recordings[0], spec.signals);
  CHECK(found.samples() == 10);
  CHECK(found.position(0, 0) == Approx(1.1e-3));
  CHECK(found.linear_hold);
}

TEST_CASE("What a spec of a diagnosis leaves out has a default", "[diagnose]") {
  const DiagnosisSpec spec = read_spec_text(R"(name: x
model: {plant: mass}
signals: {time: {rate: 250}, position: [q], input: [u]}
recordings: a.csv
)");
  CHECK(spec.model.free.empty());
  CHECK(spec.held_out.empty());
  CHECK(spec.horizon == 1.0);
  CHECK_FALSE(spec.signals.time.column.has_value());
  CHECK(spec.signals.time.rate == 250.0);
  CHECK(std::vector<std::size_t>(spec.effects) == usual_effects());
  CHECK(usual_effects().size() < catalogue().size());
}

TEST_CASE("A simulation beside every recording takes the place of a model", "[diagnose]") {
  const std::string text = R"(name: x
signals: {time: t, position: q, input: u}
recordings: [{file: a.csv, simulation: sim/a.csv}]
)";
  const Folder folder;
  const DiagnosisSpec spec = read_spec_text(text, folder);
  CHECK_FALSE(spec.model.plant.has_value());
  CHECK(spec.recordings[0].simulation == folder.path() / "sim" / "a.csv");
  CHECK_THAT(error_of([&] { read_spec_text(replaced(text, ", simulation: sim/a.csv", "")); }),
             Catch::Contains("spec.yaml:1:1: the spec needs 'model': or a simulation beside every recording"));
  CHECK_THAT(error_of([&] { read_spec_text(replaced(text, "}]", "}, b.csv]")); }), Catch::Contains("needs 'model'"));
}

TEST_CASE("A machine that is written down may be diagnosed", "[diagnose]") {
  const DiagnosisSpec spec = read_spec_text(R"(name: x
model: {plant: custom, parameters: {k: 1, r: 2}, acceleration: u - k*q - r*v, free: [r]}
signals: {time: t, position: q, input: u}
recordings: a.csv
)");
  CHECK(std::holds_alternative<Custom>(*spec.model.plant));
  CHECK(spec.model.free == std::vector<std::string>{"r"});
}

TEST_CASE("A key that a spec of a diagnosis does not have, or lacks, is shown at its place", "[diagnose]") {
  check_at("13:1", "the spec has no 'horizon', did you mean 'horizon_s'?", error_with("horizon_s", "horizon"));
  check_at("1:1", "the spec needs 'name'", error_with("name: pendulum\n", ""));
  check_at("1:1", "the spec needs 'recordings'",
           error_with("recordings: [a.csv, {file: b.csv, from: 1, to: 9.5}]\n", ""));
  check_at("5:3", "effects and remainders are what is looked for",
           error_with("  free: [friction, mass]", "  effects: [{type: constant_bias, torque: 1}]"));
  check_at("6:1", "did you mean 'signals'?", error_with("signals:\n  time", "signal:\n  time"));
  check_at("7:3", "signals needs 'time'", error_with("  time: t\n", ""));
  check_at("8:3", "signals has no 'angle'", error_with("  position: {column", "  angle: {column"));
  check_at("7:3", "signals needs 'input'", error_with("  input: {column: u, hold: linear}\n", ""));
  check_at("8:13", "position needs 'column'", error_with("column: q, ", ""));
  check_at("8:39", "did you mean 'offset'?", error_with("offset: 0.1", "ofset: 0.1"));
  check_at("10:21", "needs 'file'", error_with("{file: b.csv, from", "{from"));
  check_at("10:35", "has no 'start'", error_with("from: 1", "start: 1"));
  check_at("3:10", "did you mean 'pendulum'?", error_with("plant: pendulum", "plant: pendulun"));
  check_at("4:16", "did you mean 'length'?", error_with("length: 0.5", "lenght: 0.5"));
}

TEST_CASE("Among effects `usual` stands for all that need not be asked for, once", "[diagnose]") {
  const auto effects = [](const std::string& list) {
    return read_spec_text(replaced(kSpec, "[coulomb_friction, input_delay]", list)).effects;
  };
  EffectNames more = EffectNames::usual();
  CHECK(effects("[usual]") == more);
  CHECK(effects("[usual, coulomb_friction]") == more);
  CHECK(effects("[coulomb_friction, usual]").size() == more.size());
  CHECK(effects("[coulomb_friction, usual]").front() == EffectForm(CoulombFriction{}).index());
  more.push_back(EffectForm(JointElasticity{}).index());
  CHECK(effects("[usual, joint_elasticity, usual]") == more);
}

TEST_CASE("What depends on the temperature is looked for where that is recorded, and nowhere else", "[diagnose]") {
  const std::size_t thermal = EffectForm(ThermalFriction{}).index();
  const auto looked_for = [&](const std::string& temperature, const std::string& list) {
    const std::string text = "name: x\nmodel: {plant: mass}\nsignals: {time: t, position: q, input: u" + temperature +
                             "}\nrecordings: a.csv\n" + (list.empty() ? "" : "effects: " + list + "\n");
    const EffectNames effects = read_spec_text(text).effects;
    return std::count(effects.begin(), effects.end(), thermal);
  };
  CHECK(looked_for("", "") == 0);
  CHECK(looked_for("", "[usual]") == 0);
  for (const char* list : {"", "[usual]", "[usual, thermal_friction]", "[thermal_friction]"}) {
    CHECK(looked_for(", temperature: T", list) == 1);
  }
  CHECK(looked_for(", temperature: T", "[coulomb_friction]") == 0);
  CHECK_THAT(error_of([&] { looked_for("", "[usual, thermal_friction]"); }),
             Catch::Contains(":5:18: thermal_friction needs signals.temperature"));
  CHECK_THAT(error_of([&] { looked_for(", temperature: [T, S]", ""); }),
             Catch::Contains("temperature needs one column, or one per joint, 1"));
  CHECK_THAT(error_of([&] { looked_for(", temperature: {column: T, unit: rad}", ""); }),
             Catch::Contains("temperature in rad: a temperature is in degC, degF or K"));
  CHECK_THAT(error_of([&] { read_spec_text(replaced(kSpec, "unit: mrad", "unit: degF")); }),
             Catch::Contains("that is a temperature's unit"));
}

TEST_CASE("A value that a spec of a diagnosis cannot have is shown at its place", "[diagnose]") {
  check_at("12:11", "did you mean 'coulomb_friction'?", error_with("coulomb_friction", "coulomb_frction"));
  check_at("12:10", "a list", error_with("effects: [coulomb_friction, input_delay]", "effects: coulomb_friction"));
  check_at("5:20", "free = 'weight'", error_with("free: [friction, mass]", "free: [friction, weight]"));
  check_at("5:9", "a list", error_with("free: [friction, mass]", "free: mass"));
  check_at("4:24", "length = -0.5", error_with("length: 0.5", "length: -0.5"));
  for (const std::string horizon : {"0", "-1", "soon", ".inf", ".nan", "[1]"}) {
    INFO(horizon);
    check_at("13:12", "horizon_s", error_with("horizon_s: 0.75", "horizon_s: " + horizon));
  }
  check_at("13:1", "horizon_s has no value", error_with("horizon_s: 0.75", "horizon_s: ~"));
  check_at("7:16", "rate = 0", error_with("time: t", "time: {rate: 0}"));
  check_at("7:20", "has no 'column'", error_with("time: t", "time: {rate: 10, column: t}"));
  check_at("8:13", "scale = 0", error_with("scale: 0.001", "scale: 0"));
  check_at("9:28", "hold = 'spline'", error_with("hold: linear", "hold: spline"));
  check_at("8:52", "has no 'hold'", error_with("unit: mrad", "hold: linear"));
  check_at("10:21", "from must be before to", error_with("from: 1, to: 9.5", "from: 9.5, to: 9.5"));
  check_at("10:13", "recordings is empty", error_with("[a.csv, {file: b.csv, from: 1, to: 9.5}]", "[]"));
}

TEST_CASE("The numbers of joints in the model and the signals of a diagnosis must agree", "[diagnose]") {
  check_at("3:3", "the plant has 2 joints, signals.position has 1",
           error_with("plant: pendulum\n  parameters: {length: 0.5, mass: 2}\n  free: [friction, mass]",
                      "plant: two_link_arm"));
  check_at("9:10", "input has 1 columns, position has 2",
           error_with("{column: q, scale: 0.001, offset: 0.1, unit: mrad}", "[a, b]"));
  check_at("8:13", "position needs at least one column",
           error_with("{column: q, scale: 0.001, offset: 0.1, unit: mrad}", "[]"));
  check_at("8:13", "at most 7 joints",
           error_with("{column: q, scale: 0.001, offset: 0.1, unit: mrad}", "[a, b, c, d, e, f, g, h]"));
  check_at("8:13", "velocity needs one column", error_with("  time: t\n", "  time: t\n  velocity: [v, w]\n"));
}

TEST_CASE("What is held out must not have been trained on", "[diagnose]") {
  const auto error = [](const std::string& held_out) { return error_with("held_out: c.csv", "held_out: " + held_out); };
  for (const std::string same : {"a.csv", "./a.csv", "x/../a.csv", "b.csv"}) {
    INFO(same);
    check_at("11:11", "held_out '" + same + "' is also a training recording", error(same));
  }
  check_at("11:19", "'a.csv'", error("[c.csv, a.csv]"));
  check_at("11:11", "'b.csv'", error("{file: b.csv, from: 9}"));
  check_at("11:11", "'b.csv'", error("{file: b.csv, to: 1.5}"));
  check_at("11:11", "'b.csv'", error("{file: b.csv, from: 3, to: 4}"));
  check_at("11:11", "'a.csv'", error("{file: a.csv, from: 100}"));
  CHECK(error("{file: b.csv, from: 9.6}") == "nothing thrown");
  CHECK(error("{file: b.csv, from: 9.5}") == "nothing thrown");  // no more than the instant at which it was cut
  CHECK(error("{file: b.csv, to: 0.9}") == "nothing thrown");
  CHECK(error("[{file: b.csv, to: 0.9}, {file: b.csv, from: 10}]") == "nothing thrown");
}

TEST_CASE("A training file is recognised by another name", "[diagnose]") {
  const Folder folder;
  write_file(folder.path() / "a.csv", "t\n0\n");
  std::filesystem::create_symlink(folder.path() / "a.csv", folder.path() / "c.csv");
  CHECK_THAT(error_of([&] { read_spec_text(kSpec, folder); }), Catch::Contains("is also a training recording"));
}

TEST_CASE("What is free is named once", "[diagnose]") {
  CHECK(error_with("free: [friction, mass]", "free: [mass, mass]") != "nothing thrown");
}

TEST_CASE("A spec of a diagnosis that is not there is the machine's error", "[diagnose]") {
  CHECK_THROWS_AS(read_diagnosis_spec("/nowhere/spec.yaml"), IoError);
}

TEST_CASE("Any spec of a diagnosis is either read or refused in one line", "[diagnose][slow]") {
  RandomStream stream(6);
  const Folder folder;
  int taken = 0;
  for (int i = 0; i < 3000; ++i) {
    const std::string text = mutated(kSpec, stream);
    write_file(folder.path() / "spec.yaml", text);
    taken += accepted<SpecError>(text, [&] { read_diagnosis_spec(folder.path() / "spec.yaml"); });
  }
  CHECK(taken > 20);
}

TEST_CASE("Recordings that are not there are told where they are named, with what they may be meant to be",
          "[diagnose]") {
  const Folder folder;
  const std::string spec = replaced(replaced(kSpec, "a.csv", "first.csv"), "b.csv", "secnod.csv");
  write_file(folder.path() / "first.csv", "t,q,u\n");
  write_file(folder.path() / "second.csv", "t,q,u\n");
  const std::vector<SpecError> missing = missing_files(read_spec_text(spec, folder));
  REQUIRE(missing.size() == 2);
  CHECK_THAT(missing[0].what(),
             Catch::Contains("spec.yaml:10:25: there is no file '") && Catch::EndsWith("did you mean 'second.csv'?"));
  CHECK_THAT(missing[1].what(), Catch::Contains("spec.yaml:11:") && Catch::Contains("c.csv"));
  write_file(folder.path() / "secnod.csv", "");
  write_file(folder.path() / "c.csv", "");
  CHECK(missing_files(read_spec_text(spec, folder)).empty());
}
