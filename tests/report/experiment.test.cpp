// The page of experiments: what stands in it, what must never stand in it, and where it is written.

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "experiment/check.hpp"
#include "experiment/tabulate.hpp"
#include "experiment/write.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "report/report.hpp"
#include "report/support.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::error_of;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

constexpr std::size_t kMostBytes = std::size_t{1} << 26;

/// Results of the slide, changed, in their own folder below `folder`.
fs::path results(const Folder& folder, const std::vector<std::string>& changes = {}) {
  const Study study = slide(changes);
  const fs::path own = result_folder(folder.path(), study, 0);
  write_results(run_one(study), own, "slide.yaml");
  return own;
}

}  // namespace

TEST_CASE("A study's page holds what its figures and tables show", "[report]") {
  const Folder folder;
  const std::string html = report({results(folder)});
  CHECK_THAT(html, Contains("<h1>slide</h1>"));
  const auto data = data_of(html);
  REQUIRE(data["studies"].size() == 1);
  const auto& study = data["studies"][0];
  CHECK(study["rows"].size() == 4);
  CHECK(study["units"]["u"] == "N");
  CHECK(study["spec"]["duration"] == 2.0);
  CHECK(study["provenance"]["spec_file"] == "slide.yaml");
  CHECK_FALSE(study["provenance"].contains("wall_seconds"));  // the same results give the same page
  REQUIRE(study["runs"].size() == 4);
  const auto& run = study["runs"][2];  // SP1
  CHECK(run["name"] == "SP1");
  CHECK(run["t"].size() == 201);
  for (const char* name : {"q", "v", "u", "reference"}) {
    REQUIRE(run[name].size() == 1);
    CHECK(run[name][0].size() == 201);
  }
  CHECK(run["probing"][0][2] == "learn_a");
  CHECK(run["points"]["log_b"]["target"].size() == run["points"]["log_b"]["q"][0].size());
  REQUIRE(run["posterior"].size() == 1);
  CHECK(run["posterior"][0]["q"] == std::vector<double>{-1.0, -0.25, 0.5, 1.25, 2.0});
  for (const char* name : {"error_a", "sd_a", "mean_log_b", "sd_log_b", "log_b"}) {
    CHECK(run["posterior"][0][name].size() == 25);
  }
}

TEST_CASE("A study named like a script harms nobody", "[report]") {
  const Folder folder;
  const std::string name = "<script>alert(1)</script>";
  const fs::path own = results(folder, {"name=" + name, "description='\"</script><img src=x onerror=alert(2)>'"});
  CHECK(own.parent_path() == folder.path());
  CHECK_THAT(own.filename().string(), !Contains("<") && !Contains("/"));
  const std::string html = report({own});
  CHECK_THAT(html, Contains("<h1>&lt;script&gt;alert(1)&lt;/script&gt;</h1>"));
  CHECK_THAT(html, !Contains("<script>alert") && !Contains("<img"));
  CHECK(count(html, "<script") == 3);
  CHECK(count(html, "</script>") == 3);
  CHECK(data_of(html)["studies"][0]["name"] == name);
}

TEST_CASE("A page asks for nothing: no address but those of licences and of the SVG standard", "[report]") {
  const Folder folder;
  const std::string html = report({results(folder)});
  CHECK_THAT(html, !Contains(" src=") && !Contains("@import") && !Contains("url(") && !Contains("fetch("));
  CHECK_THAT(html, Contains("default-src 'none'"));
  for (const char* scheme : {"http://", "https://"}) {
    for (std::size_t at = html.find(scheme); at != std::string::npos; at = html.find(scheme, at + 1)) {
      const std::string address = html.substr(at, 34);
      INFO(address);
      CHECK((address.starts_with("http://www.w3.org/2000/svg") ||
             address.starts_with("https://github.com/leeoniya/uPlot")));
    }
  }
}

TEST_CASE("Long trajectories are thinned out, but not what was learned when", "[report][slow]") {
  const Folder folder;
  const auto data = data_of(report({results(folder, {"duration=200", "learner.drift_threshold=1e-9"})}));
  const auto& run = data["studies"][0]["runs"][2];
  CHECK(run["t"].size() < 5000);
  CHECK(run["t"].back() == 200.0);
  REQUIRE(run["probing"].size() > 10);
  for (const auto& [from, to, mode] : run["probing"].get<std::vector<std::tuple<double, double, std::string>>>()) {
    INFO(from);
    CHECK(std::find(run["t"].begin(), run["t"].end(), from) != run["t"].end());
  }
}

TEST_CASE("Several studies share one page in the folder above them; published numbers stand beside", "[report]") {
  const Folder folder;
  const fs::path first = results(folder, {"name=first"}), second = results(folder, {"name=second"});
  write_file(folder.path() / "published.yaml",
             "name: Table 9\nsource: nobody\ncells:\n"
             "  - {experiment: first, controller: P1, metric: squared_error, value: 1, relative: 0.01}\n"
             "  - {experiment: elsewhere, controller: P1, metric: squared_error, value: 1, relative: 0.01}\n");
  const CommandResult result = bayesctrl_with({"report", first, second, "--against", folder.path() / "published.yaml"});
  INFO(result.err);
  CHECK(result.status == 0);
  CHECK(result.out == "written: " + (folder.path() / "report.html").string() + "\n");
  const auto data = data_of(read_file(folder.path() / "report.html", kMostBytes));
  CHECK(data["studies"].size() == 2);
  CHECK(data["published"]["name"] == "Table 9");
  REQUIRE(data["published"]["cells"].size() == 1);
  CHECK(data["published"]["cells"][0]["ok"] == "no");

  CHECK(bayesctrl_with({"report", first, second, "--out", folder.path() / "page.html"}).status == 0);
  CHECK(data_of(read_file(folder.path() / "page.html", kMostBytes))["studies"] == data["studies"]);
  CHECK(bayesctrl_with({"report", first}).out == "written: " + (first / "report.html").string() + "\n");
}

TEST_CASE("The page of the paper's studies and the arm is small and holds all of Table 2", "[report]") {
  const Folder folder;
  std::vector<std::string> run{"run", "--quiet", "--no-report", "--out", folder.path()}, shown{"report"};
  for (const char* name : {"exp1", "exp2", "exp3", "arm"}) {
    run.push_back(config(name + std::string(".yaml")));
    shown.push_back(folder.path() / name);
  }
  REQUIRE(bayesctrl_with(run).status == 0);
  REQUIRE(bayesctrl_with(shown).status == 0);
  const std::string html = read_file(folder.path() / "report.html", kMostBytes);
  CHECK(html.size() < 3'000'000);
  const auto data = data_of(html);
  CHECK(data["studies"].size() == 4);
  CHECK(data["published"]["cells"].size() == 36);
  for (const auto& cell : data["published"]["cells"]) CHECK(cell["ok"] == "yes");
}

TEST_CASE("Numbers that a spec names as published stand beside the results, in the page of run and in later ones",
          "[report]") {
  const Folder folder;
  const fs::path spec = folder.path() / "slide.yaml", numbers = folder.path() / "numbers.yaml",
                 out = folder.path() / "o";
  write_file(spec, slide_text() + "published: numbers.yaml\n");
  const CommandResult missing = bayesctrl_with({"run", spec, "--out", out, "--quiet"});
  CHECK(missing.status == 0);  // a spec that was moved elsewhere still runs
  CHECK_THAT(missing.err, Contains(numbers.string() + " is not there"));
  CHECK_FALSE(data_of(read_file(out / "slide" / "report.html", kMostBytes)).contains("published"));

  write_file(numbers,
             "name: Table 9\nsource: nobody\ncells:\n"
             "  - {experiment: slide, controller: P1, metric: squared_error, value: 1, relative: 0.01}\n");
  REQUIRE(bayesctrl_with({"run", spec, "--out", out, "--quiet"}).status == 0);
  const std::string page = read_file(out / "slide" / "report.html", kMostBytes);
  CHECK(data_of(page)["published"]["name"] == "Table 9");
  CHECK(bayesctrl_with({"report", out / "slide"}).status == 0);
  CHECK(read_file(out / "slide" / "report.html", kMostBytes) == page);
}

TEST_CASE("run writes the page, one for a whole sweep, and --no-report leaves it out", "[report]") {
  const Folder folder;
  write_file(folder.path() / "slide.yaml", slide_text());
  write_file(folder.path() / "sweep.yaml", slide_text() + "sweep: {controllers.P1.gain: [1, 2, 3]}\n");
  const fs::path out = folder.path() / "out", page = out / "slide" / "report.html";
  CHECK(bayesctrl_with({"run", folder.path() / "slide.yaml", "--out", out, "--no-report", "--quiet"}).status == 0);
  CHECK_FALSE(fs::exists(page));
  CHECK(bayesctrl_with({"run", folder.path() / "slide.yaml", "--out", out, "--quiet"}).status == 0);
  CHECK(read_file(page, kMostBytes) == report({out / "slide"}));

  const fs::path swept = folder.path() / "swept";
  CHECK(bayesctrl_with({"run", folder.path() / "sweep.yaml", "--out", swept, "--quiet"}).status == 0);
  const auto data = data_of(read_file(swept / "slide" / "report.html", kMostBytes));
  CHECK(data["studies"].size() == 3);
  CHECK(data["studies"][2]["point"]["controllers.P1.gain"] == "3");
  CHECK_FALSE(fs::exists(swept / "slide" / "0001" / "report.html"));
}

TEST_CASE("A run that failed is told in the page", "[report]") {
  const Folder folder;
  const auto study = data_of(report({results(folder, unstable())}))["studies"][0];
  CHECK(study["rows"][1]["status"] == "failed");
  CHECK_THAT(study["rows"][1]["reason"].get<std::string>(), Contains("diverges"));
}

TEST_CASE("Damaged results of a study are told, with their place", "[report]") {
  const Folder folder;
  const fs::path own = results(folder);
  const auto error = [&] { return error_of<DataError>([&] { report({own}); }); };
  const auto damage = [&](const std::string& name, const std::string& content, const std::string& said) {
    const std::string before = read_file(own / name, kMostBytes);
    write_file(own / name, content);
    CHECK_THAT(error(), Contains(said));
    write_file(own / name, before);
  };
  damage("summary.json", "[1, 2", "summary.json: ");
  damage("summary.json", "{}", "damaged or of another version");
  damage("provenance.json", R"({"spec": 7})", "damaged or of another version");
  damage("SP1/trajectory.csv", "t,u,mode\n0,1,control\n", "SP1/trajectory.csv: has no column 'q'");
  damage("SP1/trajectory.csv", "t,q,v,u,mode,reference_q\n0,x,0,0,control,1\n", "SP1/trajectory.csv");
  damage("SP1/data.csv", "q,v\n1,2\n", "SP1/data.csv: has no column 'process'");
  damage("SP1/posterior.csv", "joint,q,v,error_a\n1,0,0,1\n1,0,1,1\n1,1,0,1\n", "SP1/posterior.csv: is no grid");
  CHECK_THAT(error_of<IoError>([&] { report({own, own / "SP1"}); }), Contains("SP1 holds no results"));
}

TEST_CASE("Every picture of the scripts has a text alternative, and no script makes HTML from text", "[report]") {
  const fs::path assets = fs::path(BAYESCTRL_SOURCE_DIR) / "lib" / "report" / "assets";
  for (const auto& entry : fs::directory_iterator(assets)) {
    if (entry.path().extension() != ".js") continue;
    INFO(entry.path());
    const std::string script = read_file(entry.path(), kMostBytes);
    for (std::size_t at = script.find("element(\"svg\""); at != std::string::npos;
         at = script.find("element(\"svg\"", at + 1)) {
      CHECK_THAT(script.substr(at, 300), Contains("role: \"img\""));
    }
    CHECK_THAT(script, !Contains("innerHTML") && !Contains("eval("));
  }
}

TEST_CASE("Alarms of the monitor stand in the trajectory and in the page's curves", "[report][experiment]") {
  const Folder folder;
  const StudyOutcome outcome = run_config("exp2_robust.yaml");
  const Outcome& sp1 = *outcome.find("SP1");
  REQUIRE(!sp1.result.learning.alarms.empty());
  const Table table = trajectory_table(sp1.result);
  const Column* alarm = table.find("alarm");
  REQUIRE(alarm != nullptr);
  std::size_t raised = 0;
  for (std::size_t i = 0; i < alarm->size(); ++i) raised += alarm->at(i) == Cell(std::int64_t{1}) ? 1 : 0;
  CHECK(raised == sp1.result.learning.alarms.size());
  for (const std::string other : {"paper1", "oracle"}) {
    CHECK(trajectory_table(outcome.find(other)->result).find("alarm") == nullptr);
  }
  const fs::path own = result_folder(folder.path(), outcome.study, 0);
  write_results(outcome, own, "spec.yaml");
  CHECK_THAT(report({own}), Contains("\"alarms\":[0.3"));
}
