#include <sys/mount.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <random>
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

constexpr std::size_t kMost = 10'000'000;

/// A spec with a sweep of the slide.
fs::path sweep_spec(const fs::path& folder, const std::string& sweep) {
  const fs::path spec = folder / "slide.yaml";
  write_file(spec, slide_text() + "sweep: " + sweep + "\n");
  return spec;
}

CommandResult sweep_with(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "sweep");
  return bayesctrl_with(arguments);
}

std::string table_of(const fs::path& folder) { return read_file(folder / "table.csv", kMost); }

/// Until it exists, a minute at most.
void wait_for(const fs::path& path) {
  for (int i = 0; i < 60'000 && !fs::exists(path); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

bool has_temporaries(const fs::path& folder) {
  for (const auto& entry : fs::recursive_directory_iterator(folder)) {
    if (entry.path().extension() == ".tmp") return true;
  }
  return false;
}

}  // namespace

TEST_CASE("bayesctrl sweep plans, runs and merges; its parts do the same one by one", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{grid: {controllers.P1.gain: [1, 2]}, repeat: 10}");
  const fs::path at_once = folder.path() / "once", apart = folder.path() / "apart";
  const CommandResult once = sweep_with({spec, "--out", at_once});
  CHECK(once.status == 0);
  CHECK_THAT(once.out, Catch::Contains("slide: 20 runs") && Catch::Contains("20 of 20 runs, rows in"));

  const CommandResult plan = sweep_with({"plan", spec, "--out", apart});
  CHECK(plan.status == 0);
  CHECK_THAT(plan.out, Catch::Contains("next: bayesctrl sweep run " + apart.string()));
  CHECK_THAT(sweep_with({"merge", apart}).err, Catch::Contains("0 of 20 runs are done"));
  CHECK(sweep_with({"run", apart, "--shard", "2/2"}).status == 0);
  CHECK_THAT(sweep_with({"status", apart}).out, Catch::Contains("next: bayesctrl sweep resume"));
  CHECK(sweep_with({"run", apart, "--shard", "1/2"}).status == 0);
  const auto status = nlohmann::json::parse(sweep_with({"status", apart, "--json"}).out);
  CHECK(status["n_done"] == 20);
  CHECK(status["rows"] == 80);
  CHECK(sweep_with({"merge", apart, "--quiet"}).out.empty());
  CHECK(table_of(apart) == table_of(at_once));
  CHECK(sweep_with({"resume", apart}).status == 0);
  CHECK(table_of(apart) == table_of(at_once));
}

TEST_CASE("A sweep by --set, --limit, --seed and --keep", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = folder.path() / "slide.yaml", out = folder.path() / "out";
  write_file(spec, slide_text());
  const std::vector<std::string> sweep{
      spec, "--set", "sweep={grid: {controllers.P1.gain: [1, 2, 3]}}", "--out", out, "--limit", "2", "--keep"};
  CHECK(sweep_with(sweep).status == 0);
  const std::string table = table_of(out);
  CHECK(std::count(table.begin(), table.end(), '\n') == 1 + 2 * 4);
  CHECK(fs::exists(out / "runs" / "000002" / "P1" / "trajectory.csv"));
  CHECK(bayesctrl_with({"report", out}).status == 0);
  CHECK(fs::exists(out / "report.html"));
  fs::remove_all(out / "runs");
  const CommandResult report = bayesctrl_with({"report", out});
  CHECK(report.status == 3);
  CHECK_THAT(report.err, Catch::Contains("is a sweep without its runs' own files"));
  CHECK(sweep_with({spec, "--set", "sweep={repeat: 2}", "--seed", "1", "--out", folder.path() / "a"}).status == 0);
  CHECK(sweep_with({spec, "--set", "sweep={repeat: 2}", "--seed", "2", "--out", folder.path() / "b"}).status == 0);
  CHECK(table_of(folder.path() / "a") != table_of(folder.path() / "b"));
}

TEST_CASE("A sweep's failures are counted and told with the command that repeats one", "[apps][sweep]") {
  const Folder folder;
  std::string zip;
  for (const std::string& change : unstable()) {
    const std::size_t equals = change.find('=');
    zip += change.substr(0, equals) + ": [" + change.substr(equals + 1) + "], ";
  }
  const fs::path spec = sweep_spec(folder.path(), "{zip: {" + zip + "}}"), out = folder.path() / "out";
  const CommandResult result = sweep_with({spec, "--out", out});
  CHECK(result.status == 5);
  CHECK_THAT(result.err, Catch::Contains("rows failed: bayesctrl sweep status"));
  const std::string said = sweep_with({"status", out}).out;
  CHECK_THAT(said, Catch::Contains(" rows failed") && Catch::Contains("the first again: bayesctrl run " +
                                                                      spec.string() + " --set 'sweep={}' --set '"));
}

TEST_CASE("What a user mistypes in a sweep is told", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{repeat: 3}"), out = folder.path() / "out";
  const auto said = [](const std::vector<std::string>& arguments, int status) {
    const CommandResult result = sweep_with(arguments);
    CHECK(result.status == status);
    CHECK(result.out.empty());
    return result.err;
  };
  CHECK_THAT(said({}, 2), Catch::Contains("SPEC"));
  CHECK_THAT(said({spec, "--limit", "0"}, 2), Catch::Contains("--limit"));
  CHECK_THAT(said({spec, "--set", "sweep.repaet=3", "--out", out}, 3), Catch::Contains("'repaet'"));
  CHECK_THAT(said({"run", folder.path()}, 3), Catch::Contains("is no planned sweep"));
  CHECK_THAT(said({"plan", folder.path() / "no.yaml"}, 6), Catch::Contains("no.yaml"));
  REQUIRE(sweep_with({"plan", spec, "--out", out, "--quiet"}).status == 0);
  CHECK_THAT(said({"run", out, "--shard", "3/2"}, 2), Catch::Contains("write I/N with 1 <= I <= N"));
  const CommandResult trial = sweep_with({config("trial.yaml"), "--out", folder.path() / "t"});
  CHECK(trial.status == 3);
  CHECK_THAT(trial.err, Catch::Contains("a sweep repeats a study or a diagnosis, not a trial"));
}

TEST_CASE("A sweep that is killed a hundred times at any moment ends with the table of an undisturbed one",
          "[apps][sweep][slow]") {
  using namespace std::chrono;
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{grid: {controllers.P1.gain: [1, 2, 3]}, repeat: 100}");
  const fs::path calm = folder.path() / "calm";
  const auto begin = steady_clock::now();
  REQUIRE(sweep_with({spec, "--out", calm, "--quiet"}).status == 0);
  const auto whole = duration_cast<microseconds>(steady_clock::now() - begin).count();
  const std::string expected = table_of(calm);

  std::mt19937_64 random(1);
  constexpr std::array kSignals{SIGKILL, SIGTERM, SIGINT};
  int kills = 0, sweeps = 0, resumed = 0;
  while (kills < 100 || resumed < 20) {  // it is not always killed before anything was done
    const fs::path out = folder.path() / ("out" + std::to_string(sweeps++));
    while (true) {
      Command command({BAYESCTRL_BINARY, "sweep", spec, "--out", out, "--quiet", "--jobs", "2"});
      if (kills >= 80) wait_for(out / "results");
      std::this_thread::sleep_for(microseconds(random() % static_cast<std::uint64_t>(whole)));
      command.signal(kSignals[static_cast<std::size_t>(kills) % 3]);
      const CommandResult result = command.wait();
      INFO(result.err);
      if (result.status == 0) break;  // it had ended before
      REQUIRE((result.status == 130 || result.status == 128 + SIGKILL || result.status == 128 + SIGTERM ||
               result.status == 128 + SIGINT));
      ++kills;
      if (fs::exists(out / "results")) ++resumed;
    }
    REQUIRE(table_of(out) == expected);
    CHECK_FALSE(has_temporaries(out));
    fs::remove_all(out);
  }
}

TEST_CASE("Ctrl-C in a sweep is told in one line, with what is done and how to go on", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{repeat: 20000}"), out = folder.path() / "out";
  Command command({BAYESCTRL_BINARY, "sweep", spec, "--out", out, "--progress", "none"});
  wait_for(out / "results");
  command.interrupt();
  const CommandResult result = command.wait();
  CHECK(result.status == 130);
  CHECK(std::count(result.err.begin(), result.err.end(), '\n') == 1);
  CHECK_THAT(result.err, Catch::StartsWith("interrupted: ") && Catch::Contains(" of 20000 runs are done and kept") &&
                             Catch::Contains("bayesctrl sweep resume " + out.string()));
}

TEST_CASE("Several processes in one folder do no harm", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{repeat: 300}");
  const fs::path calm = folder.path() / "calm", out = folder.path() / "out";
  REQUIRE(sweep_with({spec, "--out", calm, "--quiet"}).status == 0);
  std::vector<std::unique_ptr<Command>> commands;
  for (int i = 0; i < 4; ++i) {
    commands.push_back(std::make_unique<Command>(
        std::vector<std::string>{BAYESCTRL_BINARY, "sweep", spec, "--out", out, "--quiet", "--jobs", "1"}));
  }
  for (const auto& command : commands) {
    const CommandResult result = command->wait();
    INFO(result.err);
    CHECK(result.status == 0);
  }
  CHECK(table_of(out) == table_of(calm));
  CHECK_FALSE(has_temporaries(out));
}

TEST_CASE("A disk that is full in the middle of a sweep loses nothing", "[apps][sweep]") {
  const Folder folder;
  const fs::path spec = sweep_spec(folder.path(), "{repeat: 300}");
  const fs::path calm = folder.path() / "calm", disk = folder.path() / "disk";
  REQUIRE(sweep_with({spec, "--out", calm, "--quiet"}).status == 0);
  fs::create_directory(disk);
  if (::mount("tmpfs", disk.c_str(), "tmpfs", 0, "size=128k") != 0) {
    WARN("skipped: a small disk can be made by root alone");
    return;
  }
  const CommandResult full = sweep_with({spec, "--out", disk / "out", "--quiet"});
  CHECK(full.status == 6);
  CHECK_THAT(full.err, Catch::StartsWith("error: " + disk.string()) && Catch::Contains("No space left on device"));
  CHECK_FALSE(has_temporaries(disk));
  REQUIRE(::mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT, "size=64m") == 0);
  CHECK(sweep_with({"resume", disk / "out", "--quiet"}).status == 0);
  CHECK(table_of(disk / "out") == table_of(calm));

  REQUIRE(::mount("tmpfs", disk.c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, nullptr) == 0);
  const CommandResult refused = sweep_with({"merge", disk / "out"});
  CHECK(refused.status == 6);
  CHECK_THAT(refused.err, Catch::Contains("Read-only file system"));
  const CommandResult elsewhere = sweep_with({spec, "--out", disk / "other"});
  CHECK(elsewhere.status == 6);
  CHECK_THAT(elsewhere.err, Catch::Contains("Read-only file system"));
  ::umount(disk.c_str());
}

TEST_CASE("What a killed process left is swept up when another writes there, a living one's stays", "[io]") {
  const Folder folder;
  const fs::path out = folder.path() / "slide";
  write_file(folder.path() / "slide.yaml", slide_text());
  fs::create_directory(out);
  // A name as this host makes them, by writing one.
  std::string mine;
  {
    FileBatch batch;
    batch.add(out / "x", "x");
    for (const auto& entry : fs::directory_iterator(out)) mine = entry.path().filename().string();
  }
  const std::size_t first = mine.find('-') + 1, process = mine.find('-', first) + 1;
  const auto left_by = [&](const std::string& number) { return mine.substr(0, process) + number + "-0.tmp"; };
  const std::string dead = left_by("999999999"), living = left_by("1"), foreign = ".bayesctrl-0-999999999-0.tmp";
  for (const std::string& name : {dead, living, foreign}) write_file(out / name, "half");
  fs::last_write_time(out / foreign, fs::file_time_type::clock::now());
  REQUIRE(bayesctrl_with({"run", folder.path() / "slide.yaml", "--out", folder.path(), "--quiet"}).status == 0);
  CHECK_FALSE(fs::exists(out / dead));
  CHECK(fs::exists(out / living));
  CHECK(fs::exists(out / foreign));
  fs::last_write_time(out / foreign, fs::file_time_type::clock::now() - std::chrono::hours(48));
  REQUIRE(bayesctrl_with({"run", folder.path() / "slide.yaml", "--out", folder.path(), "--quiet"}).status == 0);
  CHECK_FALSE(fs::exists(out / foreign));
}
