#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <thread>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

constexpr int kPoints = 400;

/// A sweep that takes seconds.
std::string long_sweep() {
  std::string text = slide_text();
  text.replace(text.find("duration: 2\n"), 12, "duration: 50\n");
  text += "sweep: {seed: [1";
  for (int seed = 2; seed <= kPoints; ++seed) text += ", " + std::to_string(seed);
  return text + "]}\n";
}

/// Waits until the file is there; false after a minute.
bool appears(const fs::path& file) {
  using namespace std::chrono_literals;
  for (int i = 0; i < 60'000; ++i) {
    if (fs::exists(file)) return true;
    std::this_thread::sleep_for(1ms);
  }
  return false;
}

}  // namespace

TEST_CASE("Ctrl-C in the middle of a sweep ends with exit 130 and leaves whole files alone", "[apps]") {
  const Folder folder;
  const fs::path spec = folder.path() / "sweep.yaml", out = folder.path() / "out" / "slide";
  write_file(spec, long_sweep());
  Command command({BAYESCTRL_BINARY, "run", spec, "--out", folder.path() / "out", "--jobs", "2"});
  REQUIRE(appears(out / "0001" / "table.csv"));
  command.interrupt();
  const CommandResult result = command.wait();
  CHECK(result.status == 130);
  CHECK_THAT(result.err,
             Catch::Contains("interrupted: what was written is whole") && Catch::Contains(" of 1600 runs are left"));
  CHECK_THAT(result.out, !Catch::Contains("interrupted"));  // they are counted, not listed

  int points = 0;
  for (const auto& entry : fs::directory_iterator(out)) {
    if (!entry.is_directory()) continue;
    ++points;
    INFO(entry.path());
    const auto files = files_below(entry.path());
    for (const auto& [name, bytes] : files) {
      INFO(name);
      CHECK_FALSE(name.ends_with(".tmp"));
      CHECK(bytes.ends_with("\n"));
      if (name.ends_with(".json")) CHECK_NOTHROW(nlohmann::json::parse(bytes));
      if (name.ends_with(".csv")) CHECK(parse_csv(bytes, name).rows() > 0);
    }
    CHECK(nlohmann::json::parse(files.at("summary.json"))["controllers"].size() == 4);
    const Table table = parse_csv(files.at("table.csv"), "table.csv");
    const std::vector<std::string> status = column_texts(table, "status"), reason = column_texts(table, "reason");
    REQUIRE(table.rows() == 4);
    for (std::size_t row = 0; row < 4; ++row) CHECK((status[row] == "ok" || reason[row] == "interrupted"));
  }
  CHECK(points >= 1);
  CHECK(points < kPoints);
  CHECK(read_csv(out / "table.csv").rows() == 4 * kPoints);  // a row for every run, with its reason
}

TEST_CASE("A sweep that was interrupted gives the same as another when it is resumed or run again", "[apps][slow]") {
  const Folder folder;
  const fs::path spec = folder.path() / "sweep.yaml";
  std::string text = long_sweep();
  text.replace(text.find("duration: 50\n"), 13, "duration: 1\n");
  text.replace(text.find(", 9"), std::string::npos, "]}\n");  // eight points
  write_file(spec, text);
  const auto run = [&](const fs::path& out, const std::vector<std::string>& options = {}) {
    std::vector<std::string> arguments{"run", spec, "--out", out, "--quiet"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    CHECK(bayesctrl_with(arguments).status == 0);
    auto files = files_below(out);
    std::erase_if(files, [](const auto& file) { return file.first.ends_with("provenance.json"); });
    return files;
  };
  const fs::path first = folder.path() / "out" / "slide" / "0001" / "table.csv";
  Command command({BAYESCTRL_BINARY, "run", spec, "--out", folder.path() / "out", "--jobs", "1", "--quiet"});
  REQUIRE(appears(first));
  command.interrupt();
  command.wait();
  const auto written = fs::last_write_time(first);
  const auto fresh = run(folder.path() / "fresh");
  CHECK(run(folder.path() / "out", {"--resume"}) == fresh);
  CHECK(fs::last_write_time(first) == written);  // not run again
  CHECK(run(folder.path() / "out") == fresh);
  CHECK(fs::last_write_time(first) != written);
}

TEST_CASE("run --resume runs again what has other settings", "[apps]") {
  const Folder folder;
  const fs::path spec = folder.path() / "slide.yaml", out = folder.path() / "out";
  write_file(spec, slide_text());
  const auto table = [&](const std::vector<std::string>& options) {
    std::vector<std::string> arguments{"run", spec, "--out", out, "--resume"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    const CommandResult result = bayesctrl_with(arguments);
    CHECK(result.status == 0);
    CHECK_THAT(result.out, Catch::Contains("oracle"));  // shown, run or not
    return read_file(out / "slide" / "table.csv", 100'000);
  };
  const std::string first = table({});
  CHECK(table({}) == first);
  CHECK(table({"--set", "controllers.P1.gain=2"}) != first);
}

TEST_CASE("Ctrl-C ends a diagnosis at once, with exit 130 and a word on how to go on", "[apps]") {
  const Folder folder;
  std::string csv = "t,q,u\n";
  for (int k = 0; k < 6000; ++k) {
    csv += std::to_string(0.01 * k) + "," + std::to_string(std::sin(0.02 * k) + 0.01 * (k % 7)) + "," +
           std::to_string(k % 11) + "\n";
  }
  write_file(folder.path() / "a.csv", csv);
  write_file(folder.path() / "spec.yaml",
             "name: x\nmodel: {plant: pendulum}\nsignals: {time: t, position: q, input: u}\nrecordings: [a.csv]\n");
  Command command({BAYESCTRL_BINARY, "diagnose", folder.path() / "spec.yaml", "--out", folder.path() / "out"});
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  command.interrupt();
  const CommandResult result = command.wait();
  CHECK(result.status == 130);
  CHECK_THAT(result.err, Catch::StartsWith("interrupted: ") && Catch::Contains("run the same command again"));
  CHECK_FALSE(fs::exists(folder.path() / "out"));
}

TEST_CASE("A trial goes on where Ctrl-C ended it: what was diagnosed is kept, the figures are those of one run",
          "[apps][trial][slow]") {
  const Folder folder;
  const fs::path spec = folder.path() / "trial.yaml", out = folder.path() / "out";
  write_file(spec, "per_effect: 0\npairs: 0\ntriples: 0\noutside: 0\nnothing: 4\npysindy_cases: false\nseed: 3\n");
  Command command({BAYESCTRL_BINARY, "trial", spec, "--out", out, "--jobs", "1"});
  const fs::path first = out / "diagnoses" / "nothing_0", finished = first / "processor_seconds.json";
  REQUIRE(appears(finished));
  command.interrupt();
  const CommandResult stopped = command.wait();
  CHECK(stopped.status == 130);
  CHECK_THAT(stopped.err, Catch::Contains("the same command with --resume does the rest"));
  CHECK_FALSE(fs::exists(out / "summary.json"));

  const auto written = fs::last_write_time(first / "diagnosis.json");
  const std::vector<std::string> again{"trial", spec, "--out", out, "--resume", "--json"};
  REQUIRE(bayesctrl_with(again).status == 0);
  CHECK(fs::last_write_time(first / "diagnosis.json") == written);
  const auto cases = files_below(out).at("cases.csv");
  CHECK(std::count(cases.begin(), cases.end(), '\n') == 5);

  // Machines of another seed share nothing with these.
  std::vector<std::string> other = again;
  other.insert(other.end(), {"--seed", "4"});
  REQUIRE(bayesctrl_with(other).status == 0);
  CHECK(fs::last_write_time(first / "diagnosis.json") != written);
}
