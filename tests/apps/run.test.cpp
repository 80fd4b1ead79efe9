#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

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

std::string write_slide(const Folder& folder, const std::string& more = "") {
  const fs::path path = folder.path() / "slide.yaml";
  write_file(path, slide_text() + more);
  return path;
}

std::map<std::string, std::string> without_provenance(std::map<std::string, std::string> files) {
  std::erase_if(files, [](const auto& file) { return file.first.ends_with("provenance.json"); });
  return files;
}

}  // namespace

TEST_CASE("run --json prints exactly one JSON object and nothing else", "[apps][slow]") {
  const Folder folder;
  const std::string spec = write_slide(folder, "sweep: {seed: [1, 2]}\n"), out = folder.path() / "out";
  for (const std::vector<std::string>& more : {std::vector<std::string>{}, {"--progress", "bar"}, {"--quiet"}}) {
    // Long enough, without --json, for the bar to be drawn.
    std::vector<std::string> arguments{"run", spec, "--out", out, "--json", "--set", "duration=500"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const CommandResult result = bayesctrl_with(arguments);
    CHECK(result.status == 0);
    CHECK(result.err.empty());
    const auto object = nlohmann::json::parse(result.out);  // throws for anything after the object
    CHECK(object["ok"] == 8);
    CHECK(object["failed"] == 0);
    REQUIRE(object["studies"].size() == 1);
    CHECK(object["studies"][0]["folder"] == out + "/slide");
    CHECK(object["studies"][0]["controllers"].size() == 8);
    CHECK(object["studies"][0]["controllers"][4]["seed"] == "2");
  }
}

TEST_CASE("run --json is one JSON object when runs fail too", "[apps]") {
  const Folder folder;
  std::vector<std::string> arguments{"run", write_slide(folder), "--out", folder.path() / "out", "--json"};
  for (const std::string& change : unstable()) arguments.insert(arguments.end(), {"--set", change});
  const CommandResult result = bayesctrl_with(arguments);
  CHECK(result.status == 5);
  const auto rows = nlohmann::json::parse(result.out)["studies"][0]["controllers"];
  CHECK(rows[1]["status"] == "failed");
  CHECK_THAT(rows[1]["reason"].get<std::string>(), Contains("diverges"));
}

TEST_CASE("run --quiet prints nothing", "[apps]") {
  const Folder folder;
  const CommandResult result = bayesctrl_with({"run", write_slide(folder), "--out", folder.path() / "out", "--quiet"});
  CHECK(result.status == 0);
  CHECK((result.out + result.err).empty());
}

TEST_CASE("Everything after the first '=' of --set is the value", "[apps]") {
  const Folder folder;
  const fs::path out = folder.path() / "out";
  const CommandResult result =
      bayesctrl_with({"run", write_slide(folder), "--out", out, "--quiet", "--set", "description=a=b, c==d", "--set",
                      "initial_state.position=[-0.5]", "--set", "controllers.P1.gain=1.0e+1"});
  CHECK(result.err.empty());
  const auto spec = nlohmann::json::parse(files_below(out / "slide").at("provenance.json"))["spec"];
  CHECK(spec["description"] == "a=b, c==d");
  CHECK(spec["initial_state"]["position"] == std::vector<double>{-0.5});
  CHECK(spec["controllers"]["P1"]["gain"] == 10.0);
}

TEST_CASE("Two runs write the same bytes, whatever --jobs and --progress are", "[apps]") {
  const Folder folder;
  const std::string spec =
      write_slide(folder, "sensor: {noise: 0.001}\nsweep: {controllers.P1.gain: [1, 2], seed: [1, 2]}\n");
  const auto files = [&](const std::string& name, const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"run", spec, "--out", folder.path() / name, "--quiet"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    CHECK(bayesctrl_with(arguments).status == 0);
    return without_provenance(files_below(folder.path() / name));
  };
  const auto expected = files("first", {"--jobs", "1"});
  CHECK(expected.size() == 2 + 4 * 10);  // table.csv and report.html of the sweep, and its points
  CHECK(files("second", {"--jobs", "2", "--progress", "bar"}) == expected);
  CHECK(files("third", {"--jobs", "7"}) == expected);
  CHECK(files("other", {"--seed", "5"}) != expected);
}

TEST_CASE("A sweep has a folder per point, and one table over all of them", "[apps]") {
  const Folder folder;
  const fs::path out = folder.path() / "out";
  const CommandResult result = bayesctrl_with(
      {"run", write_slide(folder, "sweep: {controllers.P1.gain: [1, 2], duration: [1, 2]}\n"), "--out", out});
  CHECK(result.status == 0);
  const Table whole = read_csv(out / "slide" / "table.csv");
  REQUIRE(whole.rows() == 16);
  const std::vector<std::string> gain = column_texts(whole, "controllers.P1.gain");
  CHECK(gain[7] == "1");
  CHECK(gain[8] == "2");
  Table gathered;
  for (const char* point : {"0001", "0002", "0003", "0004"})
    append(gathered, read_csv(out / "slide" / point / "table.csv"));
  CHECK(to_csv(gathered) == to_csv(whole));
}

TEST_CASE("Several specs run in one command, each into its own folder", "[apps]") {
  const Folder folder;
  const std::string other = folder.path() / "other.yaml";
  write_file(other, "name: other\n" + slide_text().substr(slide_text().find('\n') + 1));
  const fs::path out = folder.path() / "out";
  CHECK(bayesctrl_with({"run", write_slide(folder), other, "--out", out, "--quiet"}).status == 0);
  CHECK(read_csv(out / "slide" / "table.csv").rows() == 4);
  CHECK(column_texts(read_csv(out / "other" / "table.csv"), "experiment").front() == "other");
}

TEST_CASE("A study's name, whatever it is, stays inside the output folder", "[apps][slow]") {
  const Folder folder;
  const fs::path out = folder.path() / "deep" / "out";
  const std::string spec = write_slide(folder);
  const std::vector<std::string> names{
      "<script>alert(1)</script>", "../../etc", "/etc/passwd", "..", "a/b", "-rf", "\\e[2J", std::string(5000, 'x')};
  for (const std::string& name : names) {
    const CommandResult result = bayesctrl_with({"run", spec, "--out", out, "--set", "name=\"" + name + "\""});
    INFO(name << result.err);
    CHECK(result.status == 0);
    CHECK(result.out.find('\x1b') == std::string::npos);  // what a terminal would obey
  }
  std::size_t folders = 0;
  for (const auto& entry : fs::directory_iterator(out)) {
    CHECK(fs::exists(entry.path() / "summary.json"));
    ++folders;
  }
  CHECK(folders == names.size());
  const CommandResult table = bayesctrl_with({"table", out / "_script-alert-1-script--dbc2cc4c"});
  CHECK_THAT(table.out, Contains("&lt;script>"));  // Markdown may be shown by a browser
  std::set<std::string> around;
  for (const auto& entry : fs::directory_iterator(folder.path())) around.insert(entry.path().filename());
  CHECK(around == std::set<std::string>{"deep", "slide.yaml"});
}

TEST_CASE("A spec of 10 MB is refused with its size", "[apps]") {
  const Folder folder;
  const std::string spec = write_slide(folder, "# " + std::string(10'000'000 - slide_text().size() - 2, 'x'));
  const CommandResult result = bayesctrl_with({"run", spec, "--out", folder.path() / "out"});
  CHECK(result.status == 3);
  CHECK(result.err == "error: " + spec + ": spec is 10000000 bytes, at most 1048576\n");
}
