#include <catch2/catch.hpp>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "io/json.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"
#include "support/studies.hpp"
#include "sweep/bundle.hpp"
#include "sweep/merge.hpp"
#include "sweep/run.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

constexpr const char* kSweep = "sweep: {grid: {controllers.P1.gain: [1, 2, 3]}, repeat: 5}\n";
constexpr std::size_t kMost = 10'000'000;

/// A planned sweep of the slide.
struct Planned {
  explicit Planned(const std::string& sweep = kSweep, int bundle = 0, int limit = 0) {
    write_file(spec, slide_text() + sweep);
    plan = plan_sweep({spec, "study", {}, limit}, folder);
    if (bundle == 0) return;
    plan.manifest.bundle = bundle;
    write_file(folder / SweepManifest::kFile, to_json(plan.manifest).dump(2) + "\n");
    plan = open_sweep(folder);
  }
  SweepRunResult run(const SweepRunOptions& options = {}) const { return run_sweep(plan, folder, options); }
  std::string merged(bool partial = false) const {
    merge_sweep(plan, folder, partial);
    return read_file(folder / "table.csv", kMost);
  }
  std::string refusal() const {
    std::string text = error_of<Error>([&] { open_sweep(folder); });
    const std::string place = root.path().string() + "/";
    for (std::size_t i = text.find(place); i != std::string::npos; i = text.find(place)) text.erase(i, place.size());
    return text;
  }

  Folder root;
  fs::path spec = root.path() / "slide.yaml", folder = root.path() / "sweep";
  SweepPlan plan;
};

SweepRunOptions shard(int index, int count, int jobs = 1) {
  SweepRunOptions options;
  options.shard = {index, count};
  options.jobs = jobs;
  return options;
}

/// The table of kSweep, run at once.
const std::string& undisturbed() {
  static const std::string table = [] {
    const Planned planned;
    planned.run();
    return planned.merged();
  }();
  return table;
}

/// A recording of a pendulum with dry friction, as CSV, with `more` below.
std::string recording_csv(const std::string& more = "") {
  const Machine machine(kPendulum, {{CoulombFriction{0.3}, 0, -1}});
  const Measured data = record(machine, -1.0, 1);
  std::string text = "t,q,u\n";
  for (std::size_t k = 0; k < data.time.size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    text += format(data.time[k]) + "," + format(data.position(row, 0)) + "," + format(data.input(row, 0)) + "\n";
  }
  return text + more;
}

std::string first_bundle(const Planned& planned) { return bundle_file(planned.plan, planned.folder, 0).string(); }

}  // namespace

TEST_CASE("The table of a sweep is the same for any number of threads, shards and runs in a file", "[sweep]") {
  const Table table = parse_csv(undisturbed(), "table.csv");
  CHECK(table.rows() == 15 * 4);  // a row for each controller
  CHECK(column_names(table)[0] == "run");
  for (const int bundle : {1, 2, 7, 100}) {
    for (const int jobs : {1, 2, 3}) {
      const Planned planned(kSweep, bundle);
      const SweepRunResult result = planned.run(shard(1, 1, jobs));
      CHECK(result.done == 15);
      CHECK(planned.merged() == undisturbed());
    }
  }
  for (const int shards : {2, 3, 20}) {
    const Planned planned(kSweep, 1);
    for (int i = shards; i >= 1; --i) planned.run(shard(i, shards));
    CHECK(planned.merged() == undisturbed());
  }
}

TEST_CASE("A row of a sweep is what the run by itself gives", "[sweep]") {
  const Table table = parse_csv(undisturbed(), "table.csv");
  const std::vector<std::string> gains = column_texts(table, "controllers.P1.gain"),
                                 seeds = column_texts(table, "seed");
  const std::vector<double> energy = numbers(table, "energy", "");
  for (const std::size_t run : {0U, 7U, 14U}) {
    const std::size_t row = 4 * run;
    const StudyOutcome alone = run_one(slide({"controllers.P1.gain=" + gains[row], "seed=" + seeds[row]}));
    CHECK(metric(alone, "P1", "energy") == energy[row]);
    CHECK(metric(alone, "SP2", "energy") == energy[row + 3]);
  }
}

TEST_CASE("What is done is not run again, what is cut short or foreign is", "[sweep]") {
  const Planned planned(kSweep, 4);
  planned.run();
  const std::string whole = read_file(first_bundle(planned), kMost);
  CHECK(planned.run().before == 15);
  std::string foreign = whole;
  foreign.replace(foreign.find("sweep ") + 6, 4, "0000");
  std::string other = whole;
  other[other.size() - 5] = other[other.size() - 5] == '1' ? '2' : '1';
  for (const std::string& bad :
       {std::string(), whole.substr(0, whole.size() / 2), whole.substr(0, 20), whole + "x\n", foreign, other}) {
    write_file(first_bundle(planned), bad);
    CHECK(sweep_status(planned.plan, planned.folder).done == 11);
    CHECK_THROWS_AS(planned.merged(), DataError);
    const SweepRunResult result = planned.run();
    CHECK(result.done == 4);
    REQUIRE(result.damaged.size() == 1);
    CHECK_THAT(result.damaged.front(), Catch::StartsWith(first_bundle(planned)));
    CHECK(read_file(first_bundle(planned), kMost) == whole);
  }
  CHECK(planned.merged() == undisturbed());
}

TEST_CASE("merge refuses what is not complete, or says which runs are missing", "[sweep]") {
  const Planned planned(kSweep, 4);
  CHECK_THAT(error_of<Error>([&] { planned.merged(true); }), Catch::Contains("0 of 15 runs are done"));
  planned.run(shard(1, 2));
  CHECK_THAT(error_of<Error>([&] { planned.merged(); }), Catch::Contains("8 of 15 runs are done") &&
                                                             Catch::Contains("sweep resume") &&
                                                             Catch::Contains("--partial"));
  const Table table = parse_csv(planned.merged(true), "table.csv");
  CHECK(table.rows() == 8 * 4 + 7);
  const std::vector<std::string> status = column_texts(table, "status"), run = column_texts(table, "run");
  CHECK(std::count(status.begin(), status.end(), "missing") == 7);
  CHECK(run[4 * 4] == "5");
  CHECK(status[4 * 4] == "missing");
  const auto summary = read_json(planned.folder / "summary.json");
  CHECK(summary["n_done"] == 8);
  CHECK(summary["n_planned"] == 15);
  const Table statistics = read_csv(planned.folder / "statistics.csv");
  CHECK(numbers(statistics, "n_done", "").front() == 8.0);
  CHECK(numbers(statistics, "n_planned", "").front() == 15.0);
}

TEST_CASE("A run that diverges is a row with its reason", "[sweep]") {
  std::string sweep = "sweep: {zip: {";
  for (const std::string& change : unstable()) {
    const std::size_t equals = change.find('=');
    sweep += change.substr(0, equals) + ": [" + change.substr(equals + 1) + "], ";
  }
  const Planned planned(sweep + "}}\n");
  planned.run();
  const SweepStatus status = sweep_status(planned.plan, planned.folder);
  CHECK(status.rows == 4);
  CHECK(status.failed > 0);
  REQUIRE_FALSE(status.reasons.empty());
  CHECK(status.reasons.begin()->second.front() == 1);
  CHECK(parse_csv(planned.merged(), "table.csv").rows() == 4);
}

TEST_CASE("A spec that has changed since the plan is refused, its remarks may change", "[sweep]") {
  const Planned planned;
  write_file(planned.spec, "# a remark\n" + slide_text() + kSweep);
  CHECK(planned.refusal() == "nothing thrown");
  for (const std::string& text : {slide_text() + "sweep: {grid: {controllers.P1.gain: [1, 2, 4]}, repeat: 5}\n",
                                  slide_text() + "sweep: {grid: {controllers.P1.gain: [1, 2, 3]}, repeat: 6}\n",
                                  slide_text() + "description: other\n" + kSweep, slide_text()}) {
    write_file(planned.spec, text);
    CHECK(planned.refusal() ==
          "slide.yaml: has changed since the sweep in sweep was planned: plan anew in another folder, or undo the "
          "change");
    CHECK_THAT(error_of<Error>([&] {
                 plan_sweep({planned.spec, "study", {}, 0}, planned.folder);
               }),
               Catch::Contains("has changed since"));
  }
  fs::remove(planned.spec);  // on another machine: the manifest has it
  CHECK(planned.refusal() == "nothing thrown");
  CHECK(planned.run().done == 15);
  CHECK(planned.merged() == undisturbed());
}

TEST_CASE("What is there can be looked at and merged after the spec or the program has changed", "[sweep]") {
  const Planned planned;
  planned.run();
  std::string text = read_file(planned.folder / "manifest.json", kMost);
  text.replace(text.find("\"revision\": \"") + 13, 0, "other-");
  write_file(planned.folder / "manifest.json", text);
  fs::remove(planned.spec);
  CHECK_THROWS_AS(open_sweep(planned.folder), DataError);
  const SweepPlan known = read_sweep(planned.folder);
  CHECK(sweep_status(known, planned.folder).done == 15);
  merge_sweep(known, planned.folder, false);
  CHECK(read_file(planned.folder / "table.csv", kMost) == undisturbed());
}

TEST_CASE("Planning again is harmless, another sweep in the same folder is refused", "[sweep]") {
  const Planned planned;
  CHECK(plan_sweep({planned.spec, "study", {}, 0}, planned.folder).manifest.hash == planned.plan.manifest.hash);
  CHECK_THAT(error_of<Error>([&] {
               plan_sweep({planned.spec, "study", {}, 3}, planned.folder);
             }),
             Catch::Contains("holds another sweep") && Catch::EndsWith("choose another folder"));
  CHECK_THAT(error_of<Error>([&] {
               plan_sweep({planned.spec, "study", {"seed=9"}, 0}, planned.folder);
             }),
             Catch::Contains("with other settings"));
}

TEST_CASE("A manifest that was edited or damaged is refused", "[sweep]") {
  const Planned planned;
  const std::string text = read_file(planned.folder / "manifest.json", kMost);
  const auto with = [&](const std::string& old, const std::string& by) {
    std::string edited = text;
    edited.replace(edited.find(old), old.size(), by);
    write_file(planned.folder / "manifest.json", edited);
    return planned.refusal();
  };
  CHECK(with("gain: [1, 2, 3]", "gain: [1, 2, 5]") ==
        "sweep/manifest.json: is damaged: its spec is not the one that was planned");
  CHECK(with("\"runs\": 15", "\"runs\": 0") == "sweep/manifest.json: is damaged: its numbers contradict each other");
  CHECK(with("\"format\": 1", "\"format\": 2") == "sweep/manifest.json: has format 2, this program knows 1");
  CHECK_THAT(with("\"revision\": \"", "\"revision\": \"other-"), Catch::Contains("was planned by revision other-"));
  CHECK_THAT(with("\"limit\": 0", "\"limit\": \"x\""), Catch::StartsWith("sweep/manifest.json: "));
  write_file(planned.folder / "manifest.json", text.substr(0, text.size() / 2));
  CHECK_THAT(planned.refusal(), Catch::StartsWith("sweep/manifest.json"));
  fs::remove(planned.folder / "manifest.json");
  CHECK_THAT(planned.refusal(), Catch::Contains("is no planned sweep"));
}

TEST_CASE("A limit takes the first runs, constraints leave points out", "[sweep]") {
  const Planned limited(kSweep, 0, 6);
  CHECK(limited.plan.manifest.runs == 6);
  limited.run();
  CHECK(undisturbed().starts_with(limited.merged()));

  const std::string constrained =
      "sweep: {grid: {controllers.P1.gain: [1, 2, 3]}, repeat: 5, constraints: "
      "[controllers.P1.gain != 2]}\n";
  const Planned planned(constrained);
  CHECK(planned.plan.manifest.points == 15);
  CHECK(planned.plan.manifest.runs == 10);
  planned.run();
  const Table table = parse_csv(planned.merged(), "table.csv"), all = parse_csv(undisturbed(), "table.csv");
  CHECK(numbers(table, "energy", "")[5 * 4] == numbers(all, "energy", "")[10 * 4]);
  CHECK_THAT(error_of<Error>([] { Planned("sweep: {constraints: [duration > 100]}\n"); }),
             Catch::Contains("the constraints leave none of 1 points"));
}

TEST_CASE("Every run's spec is read when a sweep is planned", "[sweep]") {
  CHECK_THAT(error_of<Error>([] { Planned("sweep: {grid: {controllers.P1.gain: [1, 2, -3]}}\n"); }),
             Catch::Contains("--set controllers.P1.gain=-3: gain = -3, must be a number of at least 0"));
  CHECK_THAT(error_of<Error>(
                 [] { Planned("sweep: {sample: {count: 50, of: {duration: {type: normal, mean: 1, sd: 1}}}}\n"); }),
             Catch::Contains("--set duration="));
}

TEST_CASE("Statistics are those of the runs that succeeded, with their number", "[sweep]") {
  Table table;
  table.columns = {{"run", "", std::vector<double>{1, 2, 3, 4, 5}},
                   {"gain", "", std::vector<double>{7, 7, 7, 7, 7}},
                   {"status", "", std::vector<Cell>{"ok", "ok", "failed", "ok", "missing"}},
                   {"energy", "", std::vector<Cell>{1.0, 2.0, 100.0, 6.0, Cell()}}};
  const Table statistics = statistics_of(table, {"gain"});
  REQUIRE(statistics.rows() == 1);
  const auto figure = [&](const char* name) { return numbers(statistics, name, "").front(); };
  CHECK(column_texts(statistics, "column") == std::vector<std::string>{"energy"});
  CHECK(figure("n_planned") == 5);
  CHECK(figure("n_done") == 4);
  CHECK(figure("n_failed") == 1);
  CHECK(figure("n") == 3);
  CHECK(figure("mean") == 3.0);
  CHECK(figure("sd") == Approx(std::sqrt(7.0)));
  CHECK(figure("q05") == Approx(1.1));
  CHECK(figure("median") == 2.0);
  CHECK(figure("q95") == Approx(5.6));
}

TEST_CASE("A sweep of a diagnosis has a row for each, and notices that a recording has changed", "[sweep]") {
  const Folder root;
  const fs::path recording = root.path() / "a.csv", spec = root.path() / "spec.yaml", folder = root.path() / "out";
  write_file(recording, recording_csv());
  write_file(
      spec,
      "name: p\nmodel: {plant: pendulum, parameters: {length: 0.8, friction: 0.2, mass: 0.6, gravity: 9.81}}\n"
      "signals: {time: t, position: q, input: u}\nrecordings: [a.csv]\n"
      "sweep: {grid: {effects: [[coulomb_friction], [viscous_friction, coulomb_friction]], horizon_s: [0.5, 1000]}}\n");
  CHECK_THROWS_AS(plan_sweep({spec, "trial", {}, 0}, folder), Error);
  const SweepPlan plan = plan_sweep({spec, "diagnosis", {}, 0}, folder);
  CHECK(plan.manifest.inputs.size() == 1);
  run_sweep(plan, folder, {});
  merge_sweep(plan, folder, false);
  const Table table = read_csv(folder / "table.csv");
  REQUIRE(table.rows() == 4);
  const std::vector<std::string> status = column_texts(table, "status"), reason = column_texts(table, "reason");
  CHECK(status == std::vector<std::string>{"ok", "failed", "ok", "failed"});
  CHECK_THAT(reason[1], Catch::Contains("horizon_s"));  // longer than the recording
  CHECK(column_texts(table, "verdict")[0] != "");
  write_file(recording, recording_csv("12.5,0,0\n"));
  CHECK_THAT(error_of<Error>([&] { open_sweep(folder); }), Catch::Contains("a.csv: has changed since the sweep"));
}
