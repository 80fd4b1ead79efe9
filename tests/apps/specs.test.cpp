// Commands about specs: schema, show, validate of every kind, init.

#include <catch2/catch.hpp>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "inspect/kinds.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

/// 12 s of a pendulum that slides to rest, sampled at 100 Hz, angle in degrees and time in milliseconds.
void write_recording(const fs::path& file) {
  std::ofstream csv(file);
  csv << "time [ms],angle_deg,torque\n";
  double q = 1.2, v = 0.0;
  constexpr double kStep = 1e-3;
  for (int k = 0; k < 12000; ++k) {
    if (k % 10 == 0) csv << k << "," << q * 57.29577951308232 << ",0\n";
    v += kStep * (-9.81 * std::sin(q) - 0.2 * v - (v > 0.0 ? 0.15 : -0.15));
    q += kStep * v;
  }
}

}  // namespace

TEST_CASE("schema prints the schema of each kind, or writes all of them", "[apps][slow]") {
  const Folder folder;
  CHECK(bayesctrl_with({"schema", "--out", folder.path()}).status == 0);
  for (const SpecKind& kind : spec_kinds()) {
    const std::string name(kind.name);
    const CommandResult result = bayesctrl_with({"schema", name});
    CHECK(result.status == 0);
    CHECK(nlohmann::ordered_json::parse(result.out) == kind.schema());
    CHECK(read_file(folder.path() / (name + ".json"), 1'000'000) == result.out);
  }
  CHECK(bayesctrl_with({"schema"}).out == bayesctrl_with({"schema", "study"}).out);
  CHECK_THAT(bayesctrl_with({"schema", "stduy"}).err, Contains("did you mean 'study'?"));
}

TEST_CASE("show prints a spec that runs like the one that was shown, and takes --set", "[apps]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml", shown = folder.path() / "shown.yaml";
  write_file(spec, slide_text());
  const CommandResult result = bayesctrl_with({"show", spec, "--set", "controllers.P1.gain=2"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Contains("gain: 2") && Contains("hold_periods:"));
  write_file(shown, result.out);
  CHECK(bayesctrl_with({"show", shown}).out == result.out);
  CHECK(
      bayesctrl_with({"run", spec, "--set", "controllers.P1.gain=2", "--out", folder.path() / "a", "--quiet"}).status ==
      0);
  CHECK(bayesctrl_with({"run", shown, "--out", folder.path() / "b", "--quiet"}).status == 0);
  CHECK(read_file(folder.path() / "a/slide/table.csv", 1'000'000) ==
        read_file(folder.path() / "b/slide/table.csv", 1'000'000));
}

TEST_CASE("validate takes every kind of spec and says which it is, in words or as one JSON object", "[apps]") {
  const Folder folder;
  std::vector<std::string> arguments{"validate", "--json"};
  for (const auto& entry : fs::recursive_directory_iterator(config(""))) {
    if (entry.path().extension() == ".yaml") arguments.push_back(entry.path());
  }
  const std::string broken = folder.path() / "broken.yaml";
  write_file(broken, "name: x\nmodel: {plant: mass}\nsignals: {time: t, position: q, input: u}\nrecordigns: [a.csv]\n");
  arguments.push_back(broken);
  const CommandResult result = bayesctrl_with(arguments);
  CHECK(result.status == 3);
  CHECK(result.err.empty());
  const auto list = nlohmann::json::parse(result.out)["specs"];
  REQUIRE(list.size() == arguments.size() - 2);
  std::set<std::string> kinds;
  for (std::size_t i = 0; i + 1 < list.size(); ++i) {
    INFO(list[i]);
    CHECK(list[i]["ok"] == true);
    kinds.insert(list[i]["kind"].get<std::string>());
  }
  CHECK(kinds.size() == spec_kinds().size() - 1);  // no model of a diagnosis among them
  CHECK(list.back()["ok"] == false);
  CHECK(list.back()["kind"] == "diagnosis");
  CHECK(list.back()["error"] == broken + ":4:1: the spec has no 'recordigns', did you mean 'recordings'?");
}

TEST_CASE("validate opens the recordings of a diagnosis: what diagnose would refuse is said before it runs", "[apps]") {
  const Folder folder;
  const std::string spec = folder.path() / "a.yaml", recording = folder.path() / "a.csv";
  const auto validate = [&](const std::string& csv) {
    write_file(recording, csv);
    return bayesctrl_with({"validate", spec});
  };
  write_file(spec, "name: a\nmodel: {plant: mass}\nsignals: {time: t, position: q, input: u}\nrecordings: [a.csv]\n");
  std::string rows;
  for (int k = 0; k < 41; ++k) rows += std::to_string(0.05 * k) + ",0.1,0.2\n";
  const CommandResult good = validate("t,q,u\n" + rows);
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Contains("1 recording, 0 held out") && Contains(", 41 samples in 2 s\n"));
  for (const auto& [csv, why] : {std::pair<std::string, std::string>{"t,x,u\n" + rows, "'q'"},
                                 {"t,q,u\n" + rows + "2.05,1\n", "a.csv:43"},
                                 {"t,q,u\n0,0,0\n0.1,0,0\n", "2 samples"}}) {
    const CommandResult bad = validate(csv);
    INFO(bad.err);
    CHECK(bad.status != 0);
    CHECK_THAT(bad.err, Contains("a.csv") && Contains(why));
  }
  fs::remove(recording);  // a spec may be checked where its recordings are not
  const CommandResult absent = bayesctrl_with({"validate", spec});
  CHECK(absent.status == 0);
  CHECK_THAT(absent.out, Contains("there is no file"));
}

TEST_CASE("init writes an experiment that validates and runs, and overwrites nothing", "[apps]") {
  const Folder folder;
  const CommandResult result = bayesctrl_with({"init", "experiment"}, folder.path());
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Contains("written: experiment.yaml") && Contains("next: "));
  CHECK(bayesctrl_with({"validate", "experiment.yaml"}, folder.path()).status == 0);
  CHECK(bayesctrl_with({"run", "experiment.yaml", "--set", "duration=1", "--quiet"}, folder.path()).status == 0);
  const CommandResult again = bayesctrl_with({"init", "experiment", "--plant", "mass"}, folder.path());
  CHECK(again.status == 3);
  CHECK_THAT(again.err, Contains("experiment.yaml") && Contains("--force"));
  CHECK_THAT(read_file(folder.path() / "experiment.yaml", 100'000), Contains("plant: pendulum"));
  CHECK(bayesctrl_with({"init", "experiment", "--plant", "mass", "--force"}, folder.path()).status == 0);
  CHECK_THAT(read_file(folder.path() / "experiment.yaml", 100'000), Contains("plant: mass"));
  CHECK_THAT(bayesctrl_with({"init", "experiment", "--plant", "pendulm"}).err, Contains("did you mean 'pendulum'?"));
}

TEST_CASE("init writes a diagnosis of a recording that diagnose answers", "[apps][slow]") {
  const Folder folder;
  write_recording(folder.path() / "swing.csv");
  const std::string spec = folder.path() / "specs" / "swing.yaml";
  const CommandResult result = bayesctrl_with({"init", "diagnosis", folder.path() / "swing.csv", "--out", spec});
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK(bayesctrl_with({"validate", spec}).out ==
        spec + ": ok, diagnosis 'swing', 1 recording, 1 held out, 26 effects, 1200 samples in 12 s\n");
  const CommandResult diagnosis = bayesctrl_with({"diagnose", spec, "--set", "model.parameters.friction=0.2", "--out",
                                                  folder.path() / "out", "--json", "--no-report"});
  INFO(diagnosis.err);
  REQUIRE(diagnosis.status == 0);
  CHECK(diagnosis.err.empty());
  const auto found = nlohmann::json::parse(diagnosis.out)["diagnoses"][0]["diagnosis"];
  CHECK(found["verdict"] == "named");
  CHECK(found["explanation"]["effects"][0]["name"] == "coulomb_friction");
  CHECK(bayesctrl_with({"init", "diagnosis", "nowhere.csv"}).status == 6);
}

TEST_CASE("A word that no command or option takes is answered with what was meant", "[apps]") {
  const auto error = [](const std::vector<std::string>& arguments) {
    const CommandResult result = bayesctrl_with(arguments);
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, Catch::EndsWith("Run with --help for more information.\n"));
    return result.err;
  };
  CHECK_THAT(error({"valdiate", "x"}), Catch::StartsWith("no command 'valdiate', did you mean 'validate'?"));
  CHECK_THAT(error({"shcema", "trial"}), Contains("did you mean 'schema'?"));
  CHECK_THAT(error({"run", "x", "--jbos", "3"}), Contains("run has no option '--jbos', did you mean '--jobs'?"));
  CHECK_THAT(error({"run", "--jbos=3"}), Contains("did you mean '--jobs'?"));
  CHECK_THAT(error({"init", "experimnt"}), Contains("did you mean 'experiment'?"));
  CHECK_THAT(error({"init", "experiment", "--palnt", "mass"}), Contains("did you mean '--plant'?"));
  CHECK_THAT(error({"list", "effect"}), Contains("did you mean 'effects'?"));
  CHECK_THAT(error({"run", "x", "--progress", "bra"}), Contains("did you mean 'bar'?"));
  CHECK_THAT(error({"man", "run"}), Contains("man takes no 'run'") || Contains("SPEC is required"));
}
