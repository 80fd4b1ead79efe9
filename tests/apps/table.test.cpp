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
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

/// The slide's results, and published numbers that they meet.
class Results {
 public:
  Results() {
    write_file(path("slide.yaml"), slide_text());
    REQUIRE(bayesctrl_with({"run", path("slide.yaml"), "--out", path("out"), "--quiet"}).status == 0);
    const StudyOutcome outcome = run_one(slide());
    write_published(metric(outcome, "P1", "energy"));
  }

  std::string path(const std::string& name) const { return folder_.path() / name; }
  std::string folder() const { return path("out/slide"); }

  void write_published(double energy) const {
    std::ostringstream text;
    text << std::setprecision(17) << "name: Energies\nsource: this test\ncells:\n"
         << "  - {experiment: slide, controller: P1, metric: energy, relative: 0.01, value: " << energy << "}\n"
         << "  - {experiment: slide, controller: SP1, metric: drift_points, absolute: 100, value: 1}\n"
         << "  - {experiment: slide, controller: oracle, metric: final_angle, absolute: 0.2, value: 1}\n";
    write_file(path("published.yaml"), text.str());
  }

  CommandResult check(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"check", folder(), "--against", path("published.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return bayesctrl_with(arguments);
  }

 private:
  Folder folder_;
};

}  // namespace

TEST_CASE("table prints Markdown, CSV or JSON with the same rows", "[apps]") {
  const Results results;
  const Table table = read_csv(results.folder() + "/table.csv");
  CHECK(bayesctrl_with({"table", results.folder(), "--format", "csv"}).out == to_csv(table));
  CHECK(nlohmann::ordered_json::parse(bayesctrl_with({"table", results.folder(), "--format", "json"}).out) ==
        to_json(table));
  CHECK(bayesctrl_with({"table", results.folder()}).out == to_markdown(table, 6));
  CHECK(nlohmann::json::parse(bayesctrl_with({"table", results.folder(), results.folder(), "--format", "json"}).out)
            .size() == 8);
}

TEST_CASE("table --out writes PREFIX.csv, PREFIX.md and PREFIX.json and prints nothing", "[apps]") {
  const Results results;
  const std::string prefix = results.path("new/folder/all");
  const CommandResult result = bayesctrl_with({"table", results.folder(), "--out", prefix});
  CHECK(result.status == 0);
  CHECK((result.out + result.err).empty());
  const auto files = files_below(results.path("new/folder"));
  CHECK(files.size() == 3);
  CHECK(files.at("all.csv") == read_file(results.folder() + "/table.csv", 100'000));
  CHECK(nlohmann::json::parse(files.at("all.json")).size() == 4);
  CHECK_THAT(files.at("all.md"), Catch::StartsWith("| experiment | controller |"));
}

TEST_CASE("table --against sets published numbers beside the results", "[apps]") {
  const Results results;
  const auto rows = nlohmann::json::parse(
      bayesctrl_with({"table", results.folder(), "--against", results.path("published.yaml"), "--format", "json"}).out);
  REQUIRE(rows.size() == 3);
  CHECK(rows[0]["metric"] == "energy");
  CHECK(rows[0]["ok"] == "yes");
}

TEST_CASE("check passes with a count, and exits 1 with the violated cells when a number is changed", "[apps]") {
  const Results results;
  const CommandResult good = results.check();
  CHECK(good.status == 0);
  CHECK(good.out == "Energies: 3 of 3 cells hold\n");

  results.write_published(12345.0);
  const CommandResult bad = results.check();
  CHECK(bad.status == 1);
  CHECK(bad.err.empty());
  CHECK_THAT(bad.out, Catch::StartsWith("violated: slide P1 energy: ") &&
                          Contains(", published 12345 (within 1 %)\nEnergies: 2 of 3 cells hold\n"));
  const CommandResult json = results.check({"--json"});
  CHECK(json.status == 1);
  CHECK(nlohmann::json::parse(json.out)["violated"] == 1);
}

TEST_CASE("check notices a changed result and a result that is gone", "[apps]") {
  const Results results;
  std::string table = read_file(results.folder() + "/table.csv", 100'000);
  const std::size_t row = table.find("slide,oracle,ok");
  table.replace(row, 15, "slide,oracle,failed");
  write_file(results.folder() + "/table.csv", table);
  const CommandResult result = results.check();
  CHECK(result.status == 1);
  CHECK(result.out ==
        "violated: slide oracle final_angle: no result, published 1 (within 0.2)\nEnergies: 2 of 3 cells hold\n");
}

TEST_CASE("run, table and check reproduce the paper's Table 2 from the command line", "[apps][paper]") {
  const Folder folder;
  const std::string out = folder.path() / "out";
  const std::vector<std::string> folders{out + "/exp1", out + "/exp2", out + "/exp3"};
  REQUIRE(
      bayesctrl_with({"run", config("exp1.yaml"), config("exp2.yaml"), config("exp3.yaml"), "--out", out, "--quiet"})
          .status == 0);
  std::vector<std::string> arguments{"check",    folders[0],  folders[1],
                                     folders[2], "--against", config("paper_table2.yaml")};
  const CommandResult result = bayesctrl_with(arguments);
  CHECK(result.status == 0);
  CHECK(result.out == "Table 2: 36 of 36 cells hold\n");
}

TEST_CASE("check of one study says once which published studies are not there", "[apps]") {
  const Folder folder;
  const auto check = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"check", folder.path() / "exp1", "--against", config("paper_table2.yaml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return bayesctrl_with(arguments);
  };
  REQUIRE(bayesctrl_with({"run", config("exp1.yaml"), "--out", folder.path(), "--quiet", "--no-report"}).status == 0);
  const CommandResult one = check({});
  CHECK(one.status == 0);
  CHECK(one.out ==
        "exp2 is not among the results: 12 cells not checked\nexp3 is not among the results: 12 cells not checked\n"
        "Table 2: 12 of 12 cells hold\n");
  CHECK(nlohmann::json::parse(check({"--json"}).out)["absent"].size() == 2);
  REQUIRE(bayesctrl_with(
              {"run", config("exp1.yaml"), "--out", folder.path(), "--quiet", "--no-report", "--set", "name=other"})
              .status == 0);
  fs::rename(folder.path() / "other", folder.path() / "gone");
  fs::remove_all(folder.path() / "exp1");
  fs::rename(folder.path() / "gone", folder.path() / "exp1");
  const CommandResult none = check({});
  CHECK(none.status == 3);
  CHECK_THAT(none.err, Catch::Contains("has no cell of the experiments in these folders"));
}

TEST_CASE("diff shows long texts cut, and whole to programs", "[apps]") {
  const Folder folder;
  const fs::path spec = folder.path() / "slide.yaml";
  write_file(spec, slide_text());
  const std::string text(3000, 'x');
  REQUIRE(bayesctrl_with({"run", spec, "--out", folder.path() / "a", "--quiet"}).status == 0);
  REQUIRE(
      bayesctrl_with({"run", spec, "--out", folder.path() / "b", "--quiet", "--set", "description=" + text}).status ==
      0);
  const std::vector<std::string> diff{"diff", folder.path() / "a" / "slide", folder.path() / "b" / "slide"};
  std::istringstream lines(bayesctrl_with(diff).out);
  for (std::string line; std::getline(lines, line);) CHECK(line.size() < 250);
  std::vector<std::string> csv = diff;
  csv.insert(csv.end(), {"--format", "csv"});
  CHECK_THAT(bayesctrl_with(csv).out, Catch::Contains(text));
}
