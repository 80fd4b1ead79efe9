#include <catch2/catch.hpp>
#include <sstream>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;

TEST_CASE("validate reports every bad spec with file, line and column, and every good one", "[apps]") {
  const Folder folder;
  const auto write = [&](const std::string& name, const std::string& text) {
    write_file(folder.path() / name, text);
    return name;
  };
  std::string misspelt = slide_text(), range = slide_text(), twice = slide_text(), missing = slide_text();
  misspelt.replace(misspelt.find("length_scales"), 13, "lenght_scales");
  range.replace(range.find("mass: 2"), 7, "mass: 0");
  missing.replace(missing.find("duration: 2\n"), 12, "");
  const CommandResult result = bayesctrl_with(
      {"validate", write("good.yaml", slide_text()), write("misspelt.yaml", misspelt), write("range.yaml", range),
       write("twice.yaml", twice + "duration: 3\n"), write("missing.yaml", missing), write("broken.yaml", "name: [1"),
       "nowhere.yaml", write("swept.yaml", slide_text() + "sweep: {seed: [1, 2, 3]}\n")},
      folder.path());
  CHECK(result.status != 0);
  CHECK(result.out ==
        "good.yaml: ok, study 'slide', 4 controllers\n"
        "swept.yaml: ok, study 'slide', 4 controllers, sweep of 3 points\n");
  std::istringstream lines(result.err);
  std::vector<std::string> errors;
  for (std::string line; std::getline(lines, line);) errors.push_back(line);
  REQUIRE(errors.size() == 6);
  CHECK(errors[0] ==
        "error: misspelt.yaml:10:88: squared_exponential has no 'lenght_scales', did you mean 'length_scales'?");
  CHECK(errors[1] == "error: range.yaml:2:41: mass = 0, must be a number greater than 0 (kg)");
  CHECK_THAT(errors[2], Catch::StartsWith("error: twice.yaml:18:1: ") && Catch::Contains("duration"));
  CHECK(errors[3] == "error: missing.yaml:1:1: study needs 'duration': t_f (s)");
  CHECK_THAT(errors[4], Catch::StartsWith("error: broken.yaml:"));
  CHECK(errors[5] == "error: nowhere.yaml: No such file or directory");
}

TEST_CASE("validate accepts the paper's specs, and takes --set", "[apps]") {
  std::vector<std::string> arguments{"validate"};
  for (const char* name : {"exp1.yaml", "exp2.yaml", "exp3.yaml", "arm.yaml"}) arguments.push_back(config(name));
  CHECK(bayesctrl_with(arguments).status == 0);
  arguments.insert(arguments.end(), {"--set", "duration=-1"});
  const CommandResult result = bayesctrl_with(arguments);
  CHECK(result.status == 3);
  CHECK(result.out.empty());
  CHECK(result.err.starts_with("error: --set duration=-1: duration = -1, must be a number greater than 0 (s)\n"));
}
