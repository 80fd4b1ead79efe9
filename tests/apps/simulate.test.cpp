#include <catch2/catch.hpp>
#include <cmath>
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
namespace fs = std::filesystem;

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

TEST_CASE("A hidden effect is simulated, diagnosed from a starter, and runs as the plant", "[apps][slow]") {
  const Folder folder;
  const auto in_folder = [&](std::vector<std::string> words) {
    return bayesctrl_with(std::move(words), folder.path());
  };
  std::string inputs = "t,u\n";
  for (int k = 0; k < 800; ++k) {
    const double t = 0.01 * k;
    inputs += std::to_string(t) + "," + std::to_string(2.0 * std::sin(1.3 * t) + 1.5 * std::sin(3.9 * t + 1.0)) + "\n";
  }
  write_file(folder.path() / "u.csv", inputs);
  const std::string hidden = "model.effects=[{type: coulomb_friction, level: 0.4}]", study = config("exp1.yaml");
  REQUIRE(in_folder({"simulate", study, "--input", "u.csv", "--out", "swing.csv", "--set", hidden}).status == 0);
  REQUIRE(in_folder({"init", "diagnosis", "swing.csv", "--out", "swing.yaml"}).status == 0);
  REQUIRE(in_folder({"diagnose", "swing.yaml", "--set", "model.parameters.friction=1", "--set",
                     "model.parameters.mass=0.5", "--no-report"})
              .status == 0);
  const std::string model = "results/diagnose/swing/model.yaml";
  const auto found =
      nlohmann::json::parse(read_file(folder.path() / "results/diagnose/swing/diagnosis.json", 10'000'000));
  CHECK(found["explanation"]["effects"][0]["name"] == "coulomb_friction");
  CHECK(found["explanation"]["effects"][0]["parameters"]["level"]["value"] == Approx(0.4).epsilon(1e-3));
  CHECK(in_folder({"simulate", model, "--input", "swing.csv", "--out", "corrected.csv"}).status == 0);
  const CommandResult run = in_folder(
      {"run", study, "--set", "model={file: " + model + "}", "--set", "duration=1", "--quiet", "--no-report"});
  INFO(run.err);
  CHECK(run.status == 0);
  // A learner that believes in it is as doubtful as the diagnosis was, learns little and does as the oracle.
  const CommandResult learned = in_folder(
      {"run", config("corrected_prior.yaml"), "--set",
       "controllers.corrected.belief.prior_model={file: " + (folder.path() / model).string() + "}", "--quiet"});
  INFO(learned.err);
  REQUIRE(learned.status == 0);
  const auto table =
      nlohmann::json::parse(read_file(folder.path() / "results/corrected_prior/summary.json", 10'000'000));
  const auto of = [&](const std::string& controller, const std::string& figure) -> double {
    for (const auto& row : table["controllers"]) {
      if (row["controller"] == controller) return row[figure];
    }
    throw std::out_of_range(controller);
  };
  CHECK(of("corrected", "drift_points") < of("nominal", "drift_points"));
  CHECK(of("corrected", "final_error") < 0.01);
  CHECK(of("corrected", "squared_error") == Approx(of("oracle", "squared_error")).epsilon(0.02));
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
  CHECK_THAT(text.out, Catch::StartsWith("score ") && Catch::Contains("found by 2 of 2 searches") &&
                           Catch::Contains("  controllers.P1.gain=3\n"));
  const auto list = nlohmann::json::parse(bayesctrl_with({"calibrate", search, "--json"}).out)["candidates"];
  REQUIRE(list.size() == 1);  // both searches end there
  CHECK(list[0]["searches"] == 2);
  CHECK(list[0]["settings"] == std::vector<std::string>{"controllers.P1.gain=3"});
  CHECK(list[0]["cells"][0]["ok"] == "yes");
}

TEST_CASE("simulate --out - writes to standard output, not to a file of that name", "[apps]") {
  const Folder folder;
  write_file(folder.path() / "slide.yaml", slide_text());
  const CommandResult dash = bayesctrl_with({"simulate", "slide.yaml", "--out", "-"}, folder.path());
  CHECK(dash.status == 0);
  CHECK(dash.out == bayesctrl_with({"simulate", "slide.yaml"}, folder.path()).out);
  CHECK_FALSE(fs::exists(folder.path() / "-"));
}
