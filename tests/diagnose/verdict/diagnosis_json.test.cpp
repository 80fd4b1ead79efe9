// diagnosis.json and the value behind it are the same, and a file that is not whole is told with its key.

#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "diagnose/verdict/typed.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using nlohmann::ordered_json;

namespace {

/// As it is after it was written and read as text.
ordered_json written(const Diagnosis& d) { return ordered_json::parse(to_json(d).dump(2)); }

std::string refusal(const ordered_json& json) {
  return io_examples::error_of<DataError>([&] { read_diagnosis(json, "out/diagnosis.json"); });
}

/// "explanation.effects[0].name" of a pointer "/explanation/effects/0/name".
std::string dotted(const ordered_json::json_pointer& at) {
  std::string path;
  for (ordered_json::json_pointer rest = at; !rest.empty(); rest.pop_back()) {
    const std::string& key = rest.back();
    const bool index = key.find_first_not_of("0123456789") == std::string::npos;
    const std::string part = index ? "[" + key + "]" : "." + key;
    path.insert(0, part);
  }
  return path.empty() ? path : path.substr(1);
}

/// Keys of maps from free names, and keys that need not be there.
bool may_be_missing(const std::string& path) {
  for (const char* free : {"parameters.m",
                           "parameters.k",
                           "parameters.level",
                           "parameters.torque",
                           "parameters.time",
                           "].recording",
                           "after_with_remainder",
                           "without_physics",
                           "recorded_s",
                           "searched_s",
                           "rows_left_out",
                           "residual.before",
                           "residual.after",
                           "suspicions",
                           "inclusion",
                           "alone",
                           "].share",
                           ".coulomb_friction@2",
                           ".torque_step@1",
                           ".constant_bias@2"}) {
    if (path.ends_with(free) && !path.starts_with("mismatch") && !path.starts_with("simulation_mismatch.")) return true;
  }
  return path == "simulation_mismatch";
}

/// Calls f(pointer) for every value.
void for_each_value(const ordered_json& json, const ordered_json::json_pointer& at, auto&& f) {
  if (!at.empty()) f(at);
  if (!json.is_structured()) return;
  for (const auto& [key, value] : json.items()) {
    json.is_array() ? for_each_value(value, at / static_cast<std::size_t>(std::stoul(key)), f)
                    : for_each_value(value, at / key, f);
  }
}

}  // namespace

TEST_CASE("A diagnosis that was written and read is the same", "[diagnose]") {
  Diagnosis least;
  least.units.resize(1);
  Diagnosis nothing = full_diagnosis();
  nothing.verdict = Verdict::nothing_missing;
  nothing.explanation = {};
  nothing.next_experiment.reset();
  nothing.remainder.reset();
  nothing.mismatch.channel.reset();
  Diagnosis undefined = full_diagnosis();
  undefined.explanation.effects[0].parameters.items[0].second.sd = std::nan("");
  for (const Diagnosis& d : {least, nothing, undefined, full_diagnosis()}) {
    const ordered_json json = written(d);
    CHECK(to_json(read_diagnosis(json, "x")) == json);
    CHECK(to_json(read_diagnosis(json, "x")).dump(2) == json.dump(2));  // and so is the order of its keys
  }
  for (std::size_t i = 0; i < names(Verdict{}).size(); ++i) {
    Diagnosis d = least;
    d.verdict = static_cast<Verdict>(i);
    CHECK(read_diagnosis(written(d), "x").verdict == d.verdict);
  }
}

TEST_CASE("Keys of diagnosis.json are those of its contract, all of them whatever was found", "[diagnose]") {
  Diagnosis least;
  least.units.resize(1);
  const ordered_json json = to_json(least);
  std::vector<std::string> keys;
  for (const auto& [key, value] : json.items()) keys.push_back(key);
  CHECK(keys == std::vector<std::string>{"name", "verdict", "reason", "suspicions", "joints", "units", "mismatch",
                                         "explanation", "inclusion", "remainder", "alternatives", "indistinguishable",
                                         "fit", "residual", "next_experiment", "parameters", "seconds"});
  CHECK(json["verdict"] == "too_little_data");
  CHECK(json["remainder"].is_null());
  CHECK(json["residual"] == ordered_json::object());
  CHECK(json["parameters"] == ordered_json::object());
  CHECK(json["fit"]["train"].dump() == R"({"before":null,"refit":null,"after":null})");
  CHECK(json["mismatch"]["depends_on"].dump() ==
        R"({"position":0.0,"velocity":0.0,"input":0.0,"time":0.0,"history":0.0})");
  CHECK(json["mismatch"]["channel"].is_null());
}

TEST_CASE("A key that a diagnosis lacks is named with its file", "[diagnose]") {
  const ordered_json whole = written(full_diagnosis());
  for_each_value(whole, ordered_json::json_pointer(""), [&](const ordered_json::json_pointer& at) {
    if (whole.at(at.parent_pointer()).is_array()) return;
    ordered_json damaged = whole;
    damaged.at(at.parent_pointer()).erase(at.back());
    const std::string path = dotted(at);
    INFO(path);
    if (may_be_missing(path)) {
      CHECK(refusal(damaged) == "nothing thrown");
    } else {
      CHECK_THAT(refusal(damaged), Contains("out/diagnosis.json: lacks the key '" + path + "'"));
    }
  });
}

TEST_CASE("A value of another type in a diagnosis is named with its file", "[diagnose]") {
  const ordered_json whole = written(full_diagnosis());
  for_each_value(whole, ordered_json::json_pointer(""), [&](const ordered_json::json_pointer& at) {
    ordered_json damaged = whole;
    damaged.at(at) = whole.at(at).is_boolean() ? ordered_json(7) : ordered_json(true);
    INFO(dotted(at));
    CHECK_THAT(refusal(damaged), Contains("out/diagnosis.json: " + dotted(at) + " = ") && Contains("must be"));
  });
  ordered_json other = whole;
  other["verdict"] = "nmaed";
  CHECK_THAT(refusal(other), Contains("verdict = \"nmaed\", must be one of named, nothing_missing, ambiguous"));
  other = whole;
  other["units"].erase(1);
  CHECK_THAT(refusal(other), Contains("units are of 1 joints, joints = 2"));
  CHECK_THAT(refusal(ordered_json::array()), Contains("must be an object"));
  other = whole;
  other["of a later version"] = 1;
  CHECK(to_json(read_diagnosis(other, "x")) == whole);
}

TEST_CASE("A file that is no diagnosis is told with its name", "[diagnose]") {
  const io_examples::Folder folder;
  const auto file = folder.path() / "diagnosis.json";
  CHECK_THROWS_AS(read_diagnosis(file), IoError);
  write_file(file, "{\"name\": ");
  CHECK_THAT(io_examples::error_of<DataError>([&] { read_diagnosis(file); }), Contains(file.string()));
  write_file(file, "[]");
  CHECK_THAT(io_examples::error_of<DataError>([&] { read_diagnosis(file); }), Contains(file.string()));
}
