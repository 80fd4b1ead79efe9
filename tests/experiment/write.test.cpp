#include "experiment/write.hpp"

#include <catch2/catch.hpp>
#include <set>

#include "experiment/read.hpp"
#include "experiment/tabulate.hpp"
#include "io/emit.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/read.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

std::set<std::string> names_of(const std::map<std::string, std::string>& files) {
  std::set<std::string> names;
  for (const auto& [name, bytes] : files) names.insert(name);
  return names;
}

}  // namespace

TEST_CASE("A study's folder holds its tables and, per controller, what that one has", "[experiment]") {
  const Folder folder;
  write_results(run_one(slide()), folder.path(), "slide.yaml");
  const std::set<std::string> learned{"data.csv", "posterior.csv", "trajectory.csv"};
  std::set<std::string> expected{"summary.json", "table.csv", "provenance.json", "P1/trajectory.csv",
                                 "oracle/trajectory.csv"};
  for (const std::string& name : learned) expected.insert({"SP1/" + name, "SP2/" + name});
  CHECK(names_of(files_below(folder.path())) == expected);
}

TEST_CASE("What is written reads back as what was computed", "[experiment]") {
  const Folder folder;
  const StudyOutcome outcome = run_one(slide());
  write_results(outcome, folder.path(), "slide.yaml");
  CHECK(to_csv(read_csv(folder.path() / "table.csv")) == to_csv(summary_table(outcome)));
  CHECK(to_csv(read_csv(folder.path() / "SP2" / "trajectory.csv")) ==
        to_csv(trajectory_table(outcome.find("SP2")->result)));
  CHECK(gather_tables({folder.path(), folder.path() / "table.csv"}).rows() == 8);

  const auto summary = nlohmann::ordered_json::parse(files_below(folder.path()).at("summary.json"));
  CHECK(summary["experiment"] == "slide");
  CHECK(summary["seed"] == 1);
  CHECK(summary["controllers"] == to_json(summary_table(outcome)));
}

TEST_CASE("provenance.json holds the spec with all defaults: run again, it gives the same results", "[experiment]") {
  const Folder folder;
  const Study study = slide({"sensor.noise=0.001", "seed=18446744073709551615"});
  write_results(run_one(study), folder.path() / "first", "slide.yaml");
  const auto files = files_below(folder.path() / "first");
  const auto provenance = nlohmann::ordered_json::parse(files.at("provenance.json"));
  for (const char* key : {"program", "version", "revision", "compiler"}) {
    INFO(key);
    CHECK(provenance.dump().find(key) != std::string::npos);
  }
  CHECK(provenance["spec_file"] == "slide.yaml");
  CHECK(provenance["seed"] == study.seed);
  CHECK(provenance["spec"] == to_json(study));

  write_file(folder.path() / "again.yaml", provenance["spec"].dump());
  write_results(run_one(read_studies(folder.path() / "again.yaml").front()), folder.path() / "second", "again.yaml");
  auto again = files_below(folder.path() / "second");
  for (const auto& [name, bytes] : files) {
    INFO(name);
    if (name != "provenance.json") CHECK(again.at(name) == bytes);
  }
}

TEST_CASE("A clock shows in provenance.json alone", "[experiment]") {
  const Folder folder;
  StudyOutcome outcome = run_one(slide());
  const auto files_after = [&](double seconds) {
    outcome.wall_seconds = seconds;
    write_results(outcome, folder.path(), "slide.yaml");
    auto files = files_below(folder.path());
    files.erase("provenance.json");
    return files;
  };
  CHECK(files_after(1.0) == files_after(2.0));
}

TEST_CASE("Results go to a folder named after the study, points of a sweep to numbered ones below it", "[experiment]") {
  Study study = slide();
  CHECK(result_folder("out", study, 0) == "out/slide");
  study.point = {{"seed", "1"}};
  CHECK(result_folder("out", study, 0) == "out/slide/0001");
  CHECK(result_folder("out", study, 9999) == "out/slide/10000");
  study.name = "../../etc";
  study.point.clear();
  const std::filesystem::path folder = result_folder("out", study, 0);
  CHECK(folder.lexically_normal() == folder);
  CHECK(folder.parent_path() == "out");
}

TEST_CASE("A folder without a table is an error that names it", "[experiment]") {
  const Folder folder;
  CHECK(error_of<IoError>([&] { gather_tables({folder.path()}); }) ==
        (folder.path() / "table.csv").string() + ": No such file or directory");
  write_file(folder.path() / "table.csv", "a,b\n1\n");
  CHECK(error_of<DataError>([&] { gather_tables({folder.path()}); }) ==
        (folder.path() / "table.csv").string() + ":2: has 1 cells, the header 2");
}

TEST_CASE("A table that `run` did not write is refused", "[experiment]") {
  const Folder folder;
  write_file(folder.path() / "table.csv", "experiment,controller\nexp1,P1\n");
  CHECK_THAT(error_of<DataError>([&] { gather_tables({folder.path()}); }), Catch::Contains("has no column 'status'"));
}
