#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "control/controller.hpp"
#include "control/reference.hpp"
#include "experiment/metrics.hpp"
#include "gp/kernel.hpp"
#include "io/provenance.hpp"
#include "physics/plant.hpp"
#include "support/command.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;

namespace {

const std::vector<std::string> kSubcommands{"run",   "validate", "show",   "init",       "schema",    "list",
                                            "table", "check",    "diff",   "simulate",   "calibrate", "diagnose",
                                            "trial", "bench",    "report", "completion", "man"};

std::vector<std::string> names_in(const nlohmann::ordered_json& family) {
  std::vector<std::string> names;
  for (const auto& member : family) names.push_back(member["name"]);
  return names;
}

template <class Family>
std::vector<std::string> registered(const Family* family) {
  std::vector<std::string> names;
  for (const std::string_view name : names_of(family)) names.emplace_back(name);
  return names;
}

}  // namespace

TEST_CASE("The option --help names every subcommand, examples and the exit codes", "[apps]") {
  const CommandResult result = bayesctrl_with({"--help"});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  for (const std::string& name : kSubcommands) CHECK_THAT(result.out, Contains("\n  " + name + " "));
  CHECK_THAT(result.out, Contains("Examples:") && Contains("bayesctrl run configs/exp1.yaml"));
  CHECK_THAT(result.out, Contains("0 ok") && Contains("1 a check failed") && Contains("2 usage") &&
                             Contains("3 bad spec or data") && Contains("4 numerical failure") &&
                             Contains("5 some runs failed") && Contains("6 input or output") &&
                             Contains("130 interrupted"));
}

TEST_CASE("Every subcommand explains its options", "[apps]") {
  for (const std::string& name : kSubcommands) {
    INFO(name);
    const CommandResult result = bayesctrl_with({name, "--help"});
    CHECK(result.status == 0);
    CHECK_THAT(result.out, Contains("Usage: bayesctrl " + name));
  }
  const std::string run = bayesctrl_with({"run", "--help"}).out;
  for (const char* option : {"--out", "--set", "--seed", "--jobs", "--progress", "--quiet", "--json", "Examples:"}) {
    CHECK_THAT(run, Contains(option));
  }
}

TEST_CASE("The commands that the help gives as examples are valid", "[apps]") {
  const std::string configs = std::string(BAYESCTRL_SOURCE_DIR) + "/configs/";
  CHECK(bayesctrl_with({"validate", configs + "exp1.yaml", "--set", "learner.probing_input=5", "--set", "name=probe5"})
            .status == 0);
  CHECK(bayesctrl_with({"validate", configs + "exp1.yaml", "--set", "controllers.P100.gain=50"}).status == 0);
  const CommandResult swept = bayesctrl_with(
      {"validate", configs + "exp1.yaml", "--set", "sweep={controllers.P1.gain: [1, 3, 10], seed: [1, 2]}"});
  CHECK_THAT(swept.out, Contains("sweep of 6 points"));
}

TEST_CASE("The option --version says program, version and revision", "[apps]") {
  const CommandResult result = bayesctrl_with({"--version"});
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::StartsWith("bayesctrl " + program_version() + " (") && Catch::EndsWith(")\n"));
}

TEST_CASE("list --json names every plant, kernel, controller, reference and metric", "[apps]") {
  const CommandResult result = bayesctrl_with({"list", "--json"});
  CHECK(result.status == 0);
  const auto list = nlohmann::ordered_json::parse(result.out);
  CHECK(names_in(list["plants"]) == registered(static_cast<const Plant*>(nullptr)));
  CHECK(names_in(list["controllers"]) == registered(static_cast<const Controller*>(nullptr)));
  CHECK(names_in(list["references"]) == registered(static_cast<const Reference*>(nullptr)));
  CHECK(names_in(list["kernels"]) == registered(static_cast<const decltype(Kernel::form)*>(nullptr)));
  CHECK(list["metrics"].size() == all_metrics().size());
  for (const auto& plant : list["plants"]) CHECK_FALSE(plant["equation"].get<std::string>().empty());
  for (const auto& [family, members] : list.items()) {
    for (const auto& member : members) {
      INFO(family << " " << member["name"]);
      CHECK(!member["text"].get<std::string>().empty());
    }
  }
  const auto& length = list["plants"][0]["parameters"][0];
  CHECK(length["name"] == "length");
  CHECK(length["unit"] == "m");
  CHECK(length["allowed"] == "a number greater than 0");
}

TEST_CASE("list shows one family or all, for people too", "[apps]") {
  CHECK(bayesctrl_with({"list"}).out.find("squared_exponential: ") != std::string::npos);
  const CommandResult kernels = bayesctrl_with({"list", "kernels"});
  CHECK_THAT(kernels.out, Catch::StartsWith("kernels\n") && Contains("matern52") && !Contains("pendulum"));
  CHECK(nlohmann::json::parse(bayesctrl_with({"list", "plants", "--json"}).out).size() == 1);
  CHECK(bayesctrl_with({"list", "engines"}).status == 2);
}
