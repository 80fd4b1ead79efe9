#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <mutex>
#include <set>

#include "base/format.hpp"
#include "commands.hpp"
#include "experiment/check.hpp"
#include "experiment/read.hpp"
#include "experiment/tabulate.hpp"
#include "experiment/write.hpp"
#include "io/files.hpp"
#include "io/node.hpp"
#include "report/read.hpp"
#include "report/report.hpp"
#include "terminal/plot.hpp"
#include "terminal/progress.hpp"
#include "terminal/terminal.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

struct RunCommand {
  std::vector<std::string> specs;
  std::string out = "results";
  Overrides overrides;
  int jobs = 0;
  std::string against;
  bool no_report = false;
  bool plot = false;
  bool resume = false;
  Loudness loudness;
};

/// One study of the batch and where its results go.
struct Job {
  std::string spec_name;
  fs::path published;  // numbers to set beside; empty: none
  fs::path folder;
  fs::path spec_folder;  // of the whole spec: the folder itself, or the one above a sweep's points
};

struct Batch {
  std::vector<Study> studies;
  std::vector<Job> jobs;
};

/// Where the numbers are that the page of a spec sets beside its results; empty: none.
fs::path published_for(const RunCommand& command, const fs::path& spec, const Study& study) {
  if (!command.against.empty()) return command.against;
  if (study.published.empty()) return {};
  fs::path file = spec.parent_path() / study.published;
  if (fs::exists(file)) return file;
  std::cerr << spec.string() << ": the page has no published numbers, " << file.string() << " is not there\n";
  return {};
}

Batch read_batch(const RunCommand& command) {
  Batch batch;
  std::map<fs::path, std::string> owners;
  for (const std::string& spec : command.specs) {
    read_spec(spec, {}, "study");  // or says of what kind it is
    const std::vector<Study> studies = read_studies(spec, command.overrides);
    const fs::path own = fs::path(command.out) / slug(studies.front().name);
    if (const auto [other, fresh] = owners.emplace(own, spec); !fresh) {
      throw SpecError({spec}, "has the name '" + studies.front().name + "' of " + other->second +
                                  ": their results would overwrite each other");
    }
    const fs::path published = published_for(command, spec, studies.front());
    for (std::size_t i = 0; i < studies.size(); ++i) {
      batch.jobs.push_back(
          {fs::path(spec).filename().string(), published, result_folder(command.out, studies[i], i), own});
      batch.studies.push_back(studies[i]);
    }
  }
  return batch;
}

using Beside = std::map<fs::path, PublishedTable>;  // by spec folder

/// What is said of the batch at its end.
struct Tally {
  std::size_t ok = 0;
  std::size_t failed = 0;
  std::size_t interrupted = 0;       // before their end
  std::map<fs::path, Table> tables;  // by spec folder
  std::vector<std::string> plots;    // by study

  void count(const Table& table) {
    const Column &status = *table.find("status"), &reason = *table.find("reason");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const bool cut = reason.at(row) == Cell(std::string(kInterrupted));
      ++(status.at(row) == Cell(std::string(to_name(RunStatus::ok))) ? ok : cut ? interrupted : failed);
    }
  }

  ExitCode exit() const {
    if (bayesctrl::interrupted()) return ExitCode::interrupted;
    if (failed == 0) return ExitCode::ok;
    return ok == 0 ? ExitCode::numerical : ExitCode::partial;
  }
};

/// The columns that people look at first.
Table compact(const Table& table, const Plant& plant) {
  Table result;
  for (const Column& column : table.columns) {
    const bool shown = column.name != "energy_riemann" && column.name != "new_drift_points" &&
                       column.name != "new_gain_points" && column.name != "refused_gain_estimates" &&
                       column.name != "tuning_evaluations" && column.name != "final_error";
    if (!shown || is_empty(column)) continue;
    result.columns.push_back(column);
    result.columns.back().unit = unit_for(plant, column.unit);
  }
  return result;
}

/// Position and input of each joint over time, for each controller that ran.
std::string plots_of(const StudyOutcome& outcome) {
  const PlotStyle style{terminal_width(STDOUT_FILENO), 5, has_colour(STDOUT_FILENO)};
  std::string text;
  for (const Outcome& one : outcome.outcomes) {
    if (one.result.steps.empty()) continue;
    const Eigen::Index joints = one.result.steps.front().position.size();
    std::vector<std::string> columns;
    for (Eigen::Index i = 0; i < joints; ++i) {
      columns.push_back(numbered("q", i, joints));
      columns.push_back(numbered("u", i, joints));
    }
    Table trajectory = trajectory_table(one.result);
    for (Column& column : trajectory.columns) column.unit = unit_for(outcome.study.model.plant, column.unit);
    text += outcome.study.name + ", " + one.controller + "\n" + plot_columns(trajectory, columns, style);
  }
  return text;
}

/// Without the runs that were interrupted: their number is told once.
Table without_interrupted(const Table& table) {
  const Column& reason = *table.find("reason");
  Table result;
  for (const Column& column : table.columns) {
    std::vector<Cell> cells;
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (reason.at(row) != Cell(std::string(kInterrupted))) cells.push_back(column.at(row));
    }
    result.columns.push_back({column.name, column.unit, std::move(cells)});
  }
  return result;
}

/// Of each run that failed, which it was and why.
void print_reasons(const Tally& tally) {
  for (const auto& [folder, all] : tally.tables) {
    const Table table = without_interrupted(all);
    const auto column = [&](const char* name) { return texts(table, name, folder.string()); };
    const std::vector<std::string> controllers = column("controller"), statuses = column("status");
    const std::vector<std::string> reasons = column("reason");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      if (statuses[row] == to_name(RunStatus::ok)) continue;
      std::cerr << "error: " << folder.string() << ", " << controllers[row] << ": " << reasons[row] << "\n";
    }
  }
}

void print(const Tally& tally, const Batch& batch, const RunCommand& command) {
  if (interrupted()) {
    const std::size_t runs = tally.ok + tally.failed + tally.interrupted;
    std::cerr << "interrupted: what was written is whole; " << tally.interrupted << " of " << runs
              << " runs are left, which the same command with --resume does\n";
  }
  if (command.loudness.json) {
    nlohmann::ordered_json object{{"ok", tally.ok}, {"failed", tally.failed}, {"interrupted", tally.interrupted}};
    object["studies"] = nlohmann::ordered_json::array();
    for (const auto& [folder, table] : tally.tables) {
      object["studies"].push_back({{"folder", folder.string()}, {"controllers", to_json(table)}});
    }
    std::cout << object.dump(2) << "\n";
    return;
  }
  if (command.loudness.quiet) {
    print_reasons(tally);
    return;
  }
  for (const std::string& plots : tally.plots) std::cout << plots;
  for (const auto& [folder, table] : tally.tables) {
    const auto job = std::find_if(batch.jobs.begin(), batch.jobs.end(),
                                  [&place = folder](const Job& one) { return one.spec_folder == place; });
    const Plant& plant = batch.studies[static_cast<std::size_t>(job - batch.jobs.begin())].model.plant;
    std::cout << to_text(compact(without_interrupted(table), plant), 5) << "results in " << folder.string() << "\n\n";
  }
  if (tally.failed > 0) {
    std::cout << tally.failed << " of " << tally.ok + tally.failed + tally.interrupted
              << " runs failed; the column 'reason' says why\n";
  }
}

/// The page of each spec's folder.
void write_pages(const std::set<fs::path>& folders, const Tally& tally, const Beside& beside) {
  for (const fs::path& folder : folders) {
    if (!beside.contains(folder)) {
      write_reports({folder});
      continue;
    }
    const PublishedTable& table = beside.at(folder);
    const Published published{table.name, table.source, compare(tally.tables.at(folder), table)};
    write_reports({folder}, &published);
  }
}

ExitCode run(const RunCommand& command) {
  const Batch batch = read_batch(command);
  Beside beside;
  for (const Job& job : batch.jobs) {
    if (!job.published.empty() && !beside.contains(job.spec_folder)) {
      beside[job.spec_folder] = read_published(job.published);
    }
  }
  Tally tally;
  const Loudness& loudness = command.loudness;
  Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "runs");
  std::vector<Table> tables(batch.studies.size());
  std::set<fs::path> written;  // spec folders
  std::mutex mutex;            // guards these and the tally: results come from several threads
  tally.plots.resize(batch.studies.size());
  RunOptions options;
  options.jobs = command.jobs;
  options.progress = [&](std::size_t done, std::size_t total) { progress(done, total); };
  options.stop = interrupted;
  std::vector<Study> studies;
  std::vector<std::size_t> places;  // of the studies in the batch
  for (std::size_t i = 0; i < batch.studies.size(); ++i) {
    if (command.resume) {
      if (std::optional<Table> finished = finished_results(batch.studies[i], batch.jobs[i].folder)) {
        tally.count(*finished);
        tables[i] = *std::move(finished);
        if (!fs::exists(batch.jobs[i].spec_folder / "report.html")) written.insert(batch.jobs[i].spec_folder);
        continue;
      }
    }
    studies.push_back(batch.studies[i]);
    places.push_back(i);
  }
  run_all(studies, options, [&](std::size_t place, StudyOutcome&& outcome) {
    const std::size_t index = places[place];
    tables[index] = summary_table(outcome);
    if (command.plot && !loudness.quiet && !loudness.json) tally.plots[index] = plots_of(outcome);
    const bool any = std::any_of(outcome.outcomes.begin(), outcome.outcomes.end(),
                                 [](const Outcome& one) { return one.result.reason != kInterrupted; });
    if (any) write_results(outcome, batch.jobs[index].folder, batch.jobs[index].spec_name);
    const std::lock_guard lock(mutex);
    tally.count(tables[index]);
    if (any) written.insert(batch.jobs[index].spec_folder);
  });
  for (std::size_t i = 0; i < tables.size(); ++i) append(tally.tables[batch.jobs[i].spec_folder], tables[i]);
  for (std::size_t i = 0; i < batch.jobs.size(); ++i) {
    const Job& job = batch.jobs[i];
    const bool first_point = i == 0 || batch.jobs[i - 1].spec_folder != job.spec_folder;
    if (job.folder != job.spec_folder && first_point) {
      write_file(job.spec_folder / "table.csv", to_csv(tally.tables[job.spec_folder]));
    }
    if (first_point && !job.published.empty()) {
      write_file(job.spec_folder / kPublishedFile, read_file(job.published, kMaxSpecBytes));
    }
  }
  progress.clear();
  if (!command.no_report) write_pages(written, tally, beside);
  print(tally, batch, command);
  return tally.exit();
}

}  // namespace

void declare_run(CLI::App& app, ExitCode& exit) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand("run", "Run the experiments of one or several specs and write their results");
  sub->add_option("SPEC", command->specs, "YAML spec of a study, e.g. configs/exp1.yaml")->required();
  sub->add_option("--out", command->out, "Folder of the results; each study gets a folder of its own in it")
      ->type_name("DIR")
      ->capture_default_str();
  add_set_option(*sub, command->overrides.assignments);
  sub->add_option("--seed", command->overrides.seed, "Seed of all random numbers, instead of the spec's")
      ->check(seed_check());
  add_jobs_option(*sub, command->jobs);
  sub->add_flag("--resume", command->resume,
                "Leave out studies whose results are there, with the same settings and by the same program");
  sub->add_flag("--plot", command->plot, "Draw position and input of every controller over time");
  sub->add_option("--against", command->against,
                  "Published numbers to set beside the results in report.html, instead of the spec's")
      ->type_name("SPEC");
  sub->add_flag("--no-report", command->no_report, "Write no report.html");
  add_loudness(*sub, command->loudness);
  sub->footer(
      "Examples:\n"
      "  bayesctrl run configs/exp1.yaml configs/exp2.yaml --out results\n"
      "  bayesctrl run configs/exp1.yaml --set controllers.P100.gain=50 --set name=gain50\n"
      "A spec may hold a sweep, e.g. 'sweep: {controllers.P1.gain: [1, 3, 10], seed: [1, 2]}': every combination is "
      "run.");
  sub->callback([command, &exit] { exit = run(*command); });
}

}  // namespace bayesctrl
