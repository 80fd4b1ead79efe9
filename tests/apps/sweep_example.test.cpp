#include <algorithm>
#include <catch2/catch.hpp>

#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;

namespace {

const std::string kScript = std::string(BAYESCTRL_SOURCE_DIR) + "/scripts/sweep_example.sh";

}  // namespace

TEST_CASE("scripts/sweep_example.sh sweeps a gain and a length scale and gathers a row for every run", "[apps][slow]") {
  const Folder folder;  // also the current folder: the script may be run from anywhere
  const CommandResult result = run_command(
      {"env", "BAYESCTRL=" BAYESCTRL_BINARY, kScript, (folder.path() / "my results").string()}, folder.path());
  INFO(result.err);
  REQUIRE(result.status == 0);
  for (const char* study : {"gain-10", "gain-30", "gain-100", "length-scale-5", "length-scale-10", "length-scale-20"}) {
    for (const char* controller : {"P1", "P100", "oracle", "SP1", "SP2"}) {
      CHECK_THAT(result.out, Catch::Contains("| " + std::string(study) + " | " + controller + " | ok |"));
    }
    CHECK(std::filesystem::exists(folder.path() / "my results" / study / "summary.json"));
  }
  CHECK(std::count(result.out.begin(), result.out.end(), '\n') == 2 + 6 * 5);  // two lines of header
}

TEST_CASE("The swept settings of scripts/sweep_example.sh take effect, and nothing else changes", "[apps][slow]") {
  const Folder folder;
  REQUIRE(run_command({"env", "BAYESCTRL=" BAYESCTRL_BINARY, kScript, folder.path()}).status == 0);
  const auto energy = [&](const std::string& study, std::size_t row) {
    return numbers(read_csv(folder.path() / study / "table.csv"), "energy", "")[row];
  };
  constexpr std::size_t kP1 = 0, kP100 = 1, kSP1 = 3;
  CHECK(energy("gain-10", kP100) < energy("gain-30", kP100));
  CHECK(energy("gain-30", kP100) < energy("gain-100", kP100));
  CHECK(energy("length-scale-5", kSP1) != energy("length-scale-20", kSP1));
  CHECK(energy("gain-10", kP1) == energy("length-scale-20", kP1));
  CHECK(energy("gain-10", kSP1) == energy("gain-100", kSP1));
}

TEST_CASE("scripts/sweep_example.sh without a program says what to do", "[apps]") {
  const CommandResult result = run_command({"env", "BAYESCTRL=/nowhere/bayesctrl", kScript, "/nowhere/out"});
  CHECK(result.status == 6);
  CHECK(result.err == "sweep_example: no program '/nowhere/bayesctrl': run scripts/build, or set BAYESCTRL\n");
}
