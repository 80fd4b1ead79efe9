#include "trial/trial.hpp"

#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <mutex>
#include <optional>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/hash.hpp"
#include "io/json.hpp"
#include "io/provenance.hpp"
#include "io/table.hpp"
#include "numerics/parallel.hpp"
#include "trial/cases.hpp"
#include "trial/score.hpp"

extern char** environ;

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using trial::Scored;

/// A process of its own, on one core, that sees spec and recordings only. Its processor time in seconds, negative if it
/// failed.
double diagnose_apart(const fs::path& program, const fs::path& spec, const fs::path& out) {
  std::vector<std::string> words{program.string(), "diagnose", spec.string(), "--out",      out.string(),
                                 "--jobs",         "1",        "--quiet",     "--no-report"};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t pid = 0;
  if (posix_spawn(&pid, program.c_str(), nullptr, nullptr, argv.data(), environ) != 0) {
    throw IoError("cannot start " + program.string());
  }
  int status = 0;
  rusage used{};
  wait4(pid, &status, 0, &used);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) return -1.0;
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

constexpr const char* kSpent = "processor_seconds.json";  // the last file of a diagnosis: it is finished

/// Processor seconds of a diagnosis that this revision of the program has finished, or nothing.
std::optional<double> spent_on(const fs::path& diagnosis) {
  if (!fs::exists(diagnosis / kSpent) || !fs::exists(diagnosis / "provenance.json")) return std::nullopt;
  return read_results_in(diagnosis, [&]() -> std::optional<double> {
    if (read_json(diagnosis / "provenance.json").value("revision", "") != program_revision()) return std::nullopt;
    return read_json(diagnosis / kSpent).get<double>();
  });
}

/// Calls work(i) for each i that begins before an interruption.
void in_parallel(std::size_t count, int workers, const std::function<bool()>& interrupted,
                 const std::function<void(std::size_t)>& work) {
  bayesctrl::in_parallel(count, workers, [&](std::size_t i) {
    if (!interrupted()) work(i);
  });
}

Table table_of(const std::vector<Scored>& cases) {
  Table table;
  const auto add = [&](const std::string& name, const std::function<Cell(const Scored&)>& cell) {
    std::vector<Cell> cells;
    for (const Scored& s : cases) cells.push_back(cell(s));
    table.columns.push_back({name, "", std::move(cells)});
  };
  const auto flag = [](bool yes) { return Cell(std::int64_t{yes}); };
  add("case", [](const Scored& s) { return Cell(s.name); });
  add("family", [](const Scored& s) { return Cell(s.family); });
  add("truth", [](const Scored& s) { return Cell(s.label); });
  add("size", [](const Scored& s) { return Cell(s.size); });
  add("noise", [](const Scored& s) { return Cell(s.noise); });
  add("verdict", [](const Scored& s) { return Cell(std::string(to_name(s.verdict))); });
  add("hidden", [](const Scored& s) { return Cell(s.hidden); });
  add("said", [](const Scored& s) { return Cell(s.said); });
  add("probability", [](const Scored& s) { return Cell(s.probability); });
  add("detected", [&](const Scored& s) { return flag(s.detected); });
  add("named", [&](const Scored& s) { return flag(s.named); });
  add("wrong", [&](const Scored& s) { return flag(s.wrong); });
  add("channel", [&](const Scored& s) { return flag(s.channel); });
  add("joint", [&](const Scored& s) { return flag(s.joint); });
  add("cause", [&](const Scored& s) { return flag(s.cause); });
  add("covered", [](const Scored& s) { return Cell(std::int64_t{s.covered}); });
  add("parameters", [](const Scored& s) { return Cell(std::int64_t{s.parameters}); });
  add("before", [](const Scored& s) { return Cell(s.before); });
  add("refit", [](const Scored& s) { return Cell(s.refit); });
  add("after", [](const Scored& s) { return Cell(s.after); });
  add("seconds", [](const Scored& s) { return Cell(s.seconds); });
  return table;
}

}  // namespace

TrialResult run_trial(const TrialSpec& spec, const fs::path& folder, const TrialOptions& options) {
  const auto& [program, workers, say, progress, interrupted, resume] = options;
  const std::vector<trial::Order> orders = trial::orders(spec);
  say("drawing " + std::to_string(orders.size()) + " machines with seed " + std::to_string(spec.seed));
  std::vector<ordered_json> truths(orders.size());
  std::vector<char> made(orders.size(), 0);
  std::mutex counting;
  std::size_t finished = 0;
  in_parallel(orders.size(), workers, interrupted, [&](std::size_t i) {
    const trial::Case one = trial::make_case(spec, orders[i]);
    truths[i] = one.truth;
    {
      const std::scoped_lock lock(counting);
      progress(++finished, orders.size());
    }
    if (one.files.empty()) return;
    FileBatch batch;
    const fs::path place = folder / "cases" / one.name;
    batch.add(place / "spec.yaml", to_yaml(one.spec));
    for (const auto& [file, csv] : one.files) batch.add(place / file, csv);
    batch.commit();
    made[i] = 1;
  });
  if (interrupted()) return {};
  ordered_json all = ordered_json::object();
  for (std::size_t i = 0; i < orders.size(); ++i) all[orders[i].name] = truths[i];
  const std::string sealed = all.dump(1) + "\n";
  say("truth sealed, SHA-256 " + sha256(sealed));
  const fs::path truth_file = folder / "truth.json";
  const bool same = resume && fs::exists(truth_file) && read_json(truth_file) == all;
  if (resume && !same) say("nothing to resume: no such machines in " + folder.string());
  write_file(truth_file, sealed);

  say("diagnosing in " + std::to_string(workers > 0 ? workers : core_count()) + " processes");
  std::vector<double> seconds(orders.size(), -1.0);
  finished = 0;
  in_parallel(orders.size(), workers, interrupted, [&](std::size_t i) {
    if (made[i] == 0) return;
    const fs::path place = folder / "cases" / orders[i].name;
    const fs::path out = folder / "diagnoses" / orders[i].name;
    const std::optional<double> spent = same ? spent_on(out) : std::nullopt;
    seconds[i] = spent ? *spent : diagnose_apart(program, place / "spec.yaml", out);
    if (!spent && seconds[i] >= 0.0) write_file(out / kSpent, ordered_json(seconds[i]).dump() + "\n");
    const std::scoped_lock lock(counting);
    progress(++finished, orders.size());
  });
  TrialResult result;
  result.sealed = true;
  if (interrupted()) return result;

  const ordered_json truth = read_json(truth_file);
  std::vector<Scored> scored;
  int skipped = 0, failed = 0;
  for (std::size_t i = 0; i < orders.size(); ++i) {
    if (made[i] == 0) {
      ++skipped;
      continue;
    }
    if (seconds[i] < 0.0) {
      ++failed;
      say("failed: " + orders[i].name);
      continue;
    }
    const Diagnosis diagnosis = read_diagnosis(folder / "diagnoses" / orders[i].name / "diagnosis.json");
    Scored one = trial::score(orders[i].name, truth[orders[i].name], diagnosis);
    one.seconds = seconds[i];
    if (one.family == "pysindy") {
      constexpr std::array<const char*, 4> kHidden{"nothing", "Coulomb friction 0.5", "Coulomb friction 0.08",
                                                   "quadratic drag 0.15"};
      const std::size_t hidden = truth[orders[i].name]["hidden"];
      one.detail = {{"hidden", kHidden[hidden]},
                    {"noise", one.noise},
                    {"right", hidden == 0 ? one.verdict == Verdict::nothing_missing : one.confident && !one.wrong}};
    }
    scored.push_back(std::move(one));
  }
  result.summary = trial::summary(scored);
  result.summary["seed"] = spec.seed;
  result.summary["failed"] = failed;
  result.summary["not drawn"] = skipped;
  result.summary["truth sha256"] = sha256(sealed);
  result.markdown = "# Trial on concealed effects, seed " + std::to_string(spec.seed) + "\n\n" + trial::tables(scored);
  FileBatch batch;
  batch.add(folder / "summary.json", result.summary.dump(2) + "\n");
  batch.add(folder / "table.md", result.markdown);
  batch.add(folder / "cases.csv", to_csv(table_of(scored), 6));
  batch.commit();
  return result;
}

}  // namespace bayesctrl
