#include <catch2/catch.hpp>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;

TEST_CASE("simulate prints or writes t, q, v and u of a free run", "[apps]") {
  const Folder folder;
  const std::string spec = config("exp1.yaml"), file = folder.path() / "run.csv";
  const CommandResult printed = bayesctrl_with({"simulate", spec, "--set", "duration=1"});
  CHECK(printed.status == 0);
  const Table table = parse_csv(printed.out, "out");
  CHECK(column_names(table) == std::vector<std::string>{"t", "q", "v", "u"});
  CHECK(table.rows() == 101);
  const CommandResult written = bayesctrl_with({"simulate", spec, "--set", "duration=1", "--out", file});
  CHECK(written.out.empty());
  CHECK(read_file(file, 1'000'000) == printed.out);
}

TEST_CASE("simulate takes its own output as the input of another run", "[apps]") {
  const Folder folder;
  const std::string spec = config("exp1.yaml"), input = folder.path() / "u.csv";
  write_file(input, "t,u\n0,1\n0.1,0.5\n0.3,0\n");
  const CommandResult first = bayesctrl_with({"simulate", spec, "--input", input});
  write_file(input, first.out);
  CHECK(bayesctrl_with({"simulate", spec, "--input", input}).out == first.out);
}

TEST_CASE("calibrate prints the best settings and what they give, as text or as one JSON object", "[apps]") {
  const Folder folder;
  write_file(folder.path() / "slide.yaml", slide_text());
  std::ostringstream published;
  published << std::setprecision(17)
            << "name: T\nsource: gain 3\ncells: [{experiment: slide, controller: P1, metric: energy, "
            << "relative: 0.001, value: " << metric(run_one(slide({"controllers.P1.gain=3"})), "P1", "energy")
            << "}]\n";
  write_file(folder.path() / "published.yaml", published.str());
  const std::string search = folder.path() / "search.yaml";
  write_file(search,
             "study: slide.yaml\nagainst: [published.yaml]\ncontrollers: [P1]\nstarts: 2\ndraws: 10\nsteps: 0\n"
             "vary: {controllers.P1.gain: {choices: [1, 2, 3]}}\n");
  const CommandResult text = bayesctrl_with({"calibrate", search, "--quiet", "--show", "1"});
  CHECK(text.status == 0);
  CHECK(text.err.empty());
  CHECK_THAT(text.out, Catch::StartsWith("score ") && Catch::Contains("  controllers.P1.gain=3\n"));
  const auto list = nlohmann::json::parse(bayesctrl_with({"calibrate", search, "--json"}).out)["candidates"];
  REQUIRE(list.size() == 2);
  CHECK(list[0]["settings"] == std::vector<std::string>{"controllers.P1.gain=3"});
  CHECK(list[0]["cells"][0]["ok"] == "yes");
}
