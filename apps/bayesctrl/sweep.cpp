#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "inspect/kinds.hpp"
#include "io/files.hpp"
#include "io/text.hpp"
#include "numerics/parallel.hpp"
#include "sweep/merge.hpp"
#include "sweep/run.hpp"
#include "sweep/slurm.hpp"
#include "terminal/progress.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct SweepCommand {
  std::string spec, out, folder, shard;
  std::vector<std::string> assignments;
  std::optional<std::uint64_t> seed;
  int limit = 0, jobs = 0;
  bool keep = false, partial = false;
  std::string engine, program;
  SlurmOptions slurm;
  bool dry_run = false;
  Loudness loudness;

  bool silent() const { return loudness.quiet || loudness.json; }
};

/// What is planned and where.
struct AskedSweep {
  SweepRequest request;
  fs::path folder;
};

AskedSweep asked(const SweepCommand& command) {
  std::vector<std::string> assignments = command.assignments;
  if (command.seed) assignments.push_back("seed=" + std::to_string(*command.seed));
  const Node spec = read_spec(command.spec, assignments);
  const std::string kind(kind_of(spec).name);
  const Node::Entry* name = spec.find("name");
  const std::string named = name != nullptr ? name->value.text : fs::path(command.spec).stem().string();
  return {{command.spec, kind, assignments, command.limit},
          command.out.empty() ? fs::path("results") / "sweep" / slug(named) : fs::path(command.out)};
}

ordered_json plan_json(const SweepPlan& plan, const fs::path& folder) {
  const SweepManifest& m = plan.manifest;
  return {{"folder", folder.string()},
          {"name", m.name},
          {"kind", m.kind},
          {"runs", m.runs},
          {"points", m.points},
          {"seconds_per_run", m.seconds_per_run},
          {"hash", m.hash},
          {"bundle", m.bundle}};
}

void print_plan(const SweepPlan& plan) {
  const SweepManifest& m = plan.manifest;
  const double seconds = m.seconds_per_run * m.runs / core_count();
  std::cout << m.name << ": " << m.runs << (m.runs == 1 ? " run" : " runs");
  if (m.points != m.runs) {
    std::cout << " of " << m.points << " points" << (m.kept.empty() ? "" : ", the others are ruled out by constraints")
              << (m.limit > 0 ? ", at most " + std::to_string(m.limit) : "");
  }
  std::cout << "; the first took " << format(m.seconds_per_run, 2) << " s, all about " << duration_text(seconds)
            << " on " << core_count() << (core_count() == 1 ? " core\n" : " cores\n");
}

ExitCode exit_of(const SweepStatus& status) {
  if (interrupted()) return ExitCode::interrupted;
  if (status.failed == 0) return ExitCode::ok;
  return status.failed == status.rows ? ExitCode::numerical : ExitCode::partial;
}

/// Runs what is missing. What a signal may end at once is said beforehand.
SweepRunResult run_missing(const SweepPlan& plan, const fs::path& folder, const SweepCommand& command) {
  static std::string advice;  // outlives a signal
  advice = "interrupted: finished runs are kept; the rest: bayesctrl sweep resume " + folder.string() + "\n";
  if (plan.kind->long_runs) end_at_once(advice.c_str());
  Progress progress(Progress::choose(command.loudness.progress, command.silent()), "runs");
  SweepRunOptions options;
  if (!command.shard.empty()) options.shard = parse_shard(command.shard);
  options.jobs = command.jobs;
  options.keep = command.keep;
  options.progress = [&](std::size_t done, std::size_t total) { progress(done, total); };
  options.stop = interrupted;
  SweepRunResult result = run_sweep(plan, folder, options);
  progress.clear();
  for (const std::string& file : result.damaged) std::cerr << "made again: " << file << "\n";
  if (interrupted()) {
    std::cerr << "interrupted: " << result.before + result.done << " of " << result.runs
              << " runs are done and kept; the rest: bayesctrl sweep resume " << folder.string() << "\n";
  }
  return result;
}

/// The figures that people look at first.
Table main_figures(const Table& statistics) {
  Table table;
  for (const char* name : {"controller", "column", "n", "q05", "median", "q95"}) {
    const Column* column = statistics.find(name);
    if (column != nullptr && !is_empty(*column)) table.columns.push_back(*column);
  }
  return table;
}

void print_merged(const Merged& merged, const fs::path& folder) {
  std::cout << to_text(main_figures(merged.statistics), 5) << merged.done << " of " << merged.planned
            << " runs, rows in " << (folder / "table.csv").string() << ", these figures in "
            << (folder / "statistics.csv").string() << "\n";
}

ordered_json status_json(const SweepPlan& plan, const SweepStatus& status, const fs::path& folder) {
  ordered_json object = plan_json(plan, folder);
  object["n_done"] = status.done;
  object["n_planned"] = status.planned;
  object["rows"] = status.rows;
  object["rows_failed"] = status.failed;
  object["reasons"] = ordered_json::object();
  for (const auto& [reason, runs] : status.reasons) object["reasons"][reason] = runs;
  object["damaged"] = status.damaged;
  return object;
}

/// The command that repeats one run by itself.
std::string single_run(const SweepPlan& plan, int run) {
  std::string text = "bayesctrl " + std::string(plan.kind->command) + " " + plan.manifest.spec;
  for (const std::string& assignment : plan.manifest.assignments) text += " --set " + shell_quoted(assignment);
  if (plan.sweep.given) text += " --set 'sweep={}'";
  for (const auto& [path, value] : plan.point(run - 1)) text += " --set " + shell_quoted(path + "=" + value);
  return text;
}

void print_status(const SweepPlan& plan, const SweepStatus& status, const fs::path& folder) {
  std::cout << plan.manifest.name << ": " << status.done << " of " << status.planned << " runs are done";
  if (status.failed > 0) std::cout << ", " << status.failed << " of " << status.rows << " rows failed";
  std::cout << "\n";
  for (const auto& [reason, runs] : status.reasons) {
    std::cout << "  " << runs.size() << " x " << reason << "; the first again: " << single_run(plan, runs.front())
              << "\n";
  }
  for (const std::string& file : status.damaged) std::cout << "  to be made again: " << file << "\n";
  std::cout << "  next: bayesctrl sweep " << (status.done < status.planned ? "resume " : "merge ") << folder.string()
            << "\n";
}

/// Runs what is missing and, once nothing is, merges.
ExitCode run_and_merge(const SweepPlan& plan, const fs::path& folder, const SweepCommand& command) {
  const SweepRunResult result = run_missing(plan, folder, command);
  if (interrupted()) return ExitCode::interrupted;
  const SweepStatus status = sweep_status(plan, folder);
  const Merged merged = merge_sweep(plan, folder, false);
  if (command.loudness.json) {
    ordered_json object = status_json(plan, status, folder);
    object["statistics"] = to_json(merged.statistics);
    std::cout << object.dump(2) << "\n";
  } else if (!command.loudness.quiet) {
    if (result.before > 0) std::cout << result.before << " runs had been done before\n";
    print_merged(merged, folder);
  }
  if (!command.loudness.json && status.failed > 0) {
    std::cerr << status.failed << " of " << status.rows << " rows failed: bayesctrl sweep status " << folder.string()
              << " says why\n";
  }
  return exit_of(status);
}

void add_jobs(CLI::App& sub, SweepCommand& command) {
  add_jobs_option(sub, command.jobs);
  sub.add_flag("--keep", command.keep, "Also keep what each run writes by itself, in DIR/runs");
}

void add_request(CLI::App& sub, SweepCommand& command) {
  sub.add_option("--out", command.out, "Folder of the sweep; default: results/sweep/NAME")->type_name("DIR");
  add_set_option(sub, command.assignments);
  sub.add_option("--seed", command.seed, "Seed of all random numbers, instead of the spec's")->check(seed_check());
  sub.add_option("--limit", command.limit, "Only the first N runs of the plan")
      ->type_name("N")
      ->check(CLI::Range(1, static_cast<int>(kMostSweepPoints)));
}

CLI::App* add_part(CLI::App& sweep, const std::shared_ptr<SweepCommand>& command, const char* name, const char* text) {
  CLI::App* sub = sweep.add_subcommand(name, text);
  sub->add_option("DIR", command->folder, "Folder of a planned sweep")->required();
  add_loudness(*sub, command->loudness);
  return sub;
}

/// Submits to Slurm, waits, and says what came of it.
ExitCode submit(SweepCommand& command) {
  const fs::path folder = command.folder;
  const SweepPlan plan = open_sweep(folder);
  if (command.engine == "local") {
    if (!command.dry_run) return run_and_merge(plan, folder, command);
    std::cout << "bayesctrl sweep resume " << folder.string() << "\n";
    return ExitCode::ok;
  }
  SlurmOptions& slurm = command.slurm;
  slurm.program = command.program.empty() ? fs::read_symlink("/proc/self/exe") : fs::path(command.program);
  if (command.dry_run) {
    const SlurmScripts scripts = slurm_scripts(plan, folder, slurm);
    const int shards = slurm_shards(plan, slurm);
    std::cout << "# sbatch --array=1" << (shards > 1 ? "-" + std::to_string(shards) : "") << ", of which what is done "
              << "is left out:\n"
              << scripts.array << "\n# sbatch --dependency=afterany:ARRAY:\n"
              << scripts.merge;
    return ExitCode::ok;
  }
  Progress progress(Progress::choose(command.loudness.progress, command.silent()), "runs");
  slurm.say = [&](const std::string& line) {
    progress.clear();
    if (!command.silent()) std::cerr << line << "\n";
  };
  slurm.progress = [&](std::size_t done, std::size_t total) { progress(done, total); };
  slurm.stop = interrupted;
  submit_to_slurm(plan, folder, slurm);
  progress.clear();
  if (interrupted()) {
    std::cerr << "interrupted: the jobs go on; wait for them again with bayesctrl sweep submit " << folder.string()
              << "\n";
    return ExitCode::interrupted;
  }
  const SweepStatus status = sweep_status(plan, folder);
  if (command.loudness.json) std::cout << status_json(plan, status, folder).dump(2) << "\n";
  if (status.done < status.planned) {
    throw IoError(std::to_string(status.planned - status.done) + " of " + std::to_string(status.planned) +
                  " runs are missing after " + std::to_string(slurm.attempts) +
                  " attempts; what the tasks said: " + (folder / "slurm").string());
  }
  const Merged merged = merge_sweep(plan, folder, false);  // as the dependent job has, on a node that may be gone
  if (!command.silent()) print_merged(merged, folder);
  return exit_of(status);
}

void declare_submit(CLI::App& sweep, const std::shared_ptr<SweepCommand>& command, ExitCode& exit) {
  CLI::App* sub = add_part(sweep, command, "submit",
                           "Run what is missing on a cluster: one array job, merged by a job that depends on it");
  sub->add_option("--engine", command->engine, "slurm, or local: this machine, as resume does")
      ->check(one_of({"slurm", "local"}))
      ->required();
  sub->add_option("--shards", command->slurm.shards, "Tasks of the array; default: of about five minutes each")
      ->type_name("N")
      ->check(CLI::Range(1, static_cast<int>(kMostSweepPoints)));
  sub->add_option("--cpus", command->slurm.cpus, "Cores of each task")
      ->check(CLI::Range(1, kMostJobs))
      ->capture_default_str();
  sub->add_option("--attempts", command->slurm.attempts, "How often what is missing is submitted")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--sbatch", command->slurm.directives, "An option for sbatch, e.g. --sbatch=--partition=short")
      ->type_name("OPTION")
      ->allow_extra_args(false);
  sub->add_option("--program", command->program, "bayesctrl as the nodes find it; default: this program's path")
      ->type_name("PATH");
  sub->add_flag("--dry-run", command->dry_run, "Print what would be submitted");
  sub->callback([command, &exit] {
    keep_memory();
    exit = submit(*command);
  });
}

void declare_parts(CLI::App& sweep, ExitCode& exit) {
  auto command = std::make_shared<SweepCommand>();
  CLI::App* plan = sweep.add_subcommand("plan", "Read every run's spec, time the first, and write DIR/manifest.json");
  plan->add_option("SPEC", command->spec, "YAML spec of a study or a diagnosis with a sweep")->required();
  add_request(*plan, *command);
  add_loudness(*plan, command->loudness);
  plan->callback([command] {
    const auto [request, folder] = asked(*command);
    const SweepPlan planned = plan_sweep(request, folder);
    if (command->loudness.json) std::cout << plan_json(planned, folder).dump(2) << "\n";
    if (command->silent()) return;
    print_plan(planned);
    std::cout << "next: bayesctrl sweep run " << folder.string() << "\n";
  });

  CLI::App* run = add_part(sweep, command, "run", "Run what is missing of a planned sweep, or of one shard of it");
  run->add_option("--shard", command->shard, "Only part I of N, e.g. 2/8")->type_name("I/N");
  add_jobs(*run, *command);
  run->callback([command, &exit] {
    keep_memory();
    const SweepPlan planned = open_sweep(command->folder);
    const SweepRunResult result = run_missing(planned, command->folder, *command);
    const SweepStatus status = sweep_status(planned, command->folder);
    if (command->loudness.json) std::cout << status_json(planned, status, command->folder).dump(2) << "\n";
    if (!command->silent() && !interrupted()) {
      std::cout << result.done << (result.done == 1 ? " run" : " runs") << " now, " << result.before << " before\n";
      print_status(planned, status, command->folder);
    }
    exit = exit_of(status);
  });

  CLI::App* status = add_part(sweep, command, "status", "Say what is done, what failed and why, and what is missing");
  status->callback([command] {
    const SweepPlan planned = read_sweep(command->folder);
    const SweepStatus found = sweep_status(planned, command->folder);
    if (command->loudness.json)
      std::cout << status_json(planned, found, command->folder).dump(2) << "\n";
    else
      print_status(planned, found, command->folder);
  });

  CLI::App* resume = add_part(sweep, command, "resume", "Run what is missing, and merge");
  add_jobs(*resume, *command);
  resume->callback([command, &exit] {
    keep_memory();
    exit = run_and_merge(open_sweep(command->folder), command->folder, *command);
  });

  CLI::App* merge = add_part(sweep, command, "merge", "Write DIR/table.csv, statistics.csv and summary.json");
  merge->add_flag("--partial", command->partial, "Even where runs are missing: each is then a row that says so");
  merge->callback([command] {
    const Merged merged = merge_sweep(read_sweep(command->folder), command->folder, command->partial);
    if (command->loudness.json) {
      std::cout << ordered_json{{"n_done", merged.done},
                                {"n_planned", merged.planned},
                                {"statistics", to_json(merged.statistics)}}
                       .dump(2)
                << "\n";
    } else if (!command->loudness.quiet) {
      print_merged(merged, command->folder);
    }
  });
  declare_submit(sweep, command, exit);
}

}  // namespace

void declare_sweep(CLI::App& app, ExitCode& exit) {
  auto command = std::make_shared<SweepCommand>();
  CLI::App* sub = app.add_subcommand(
      "sweep", "Repeat a study or a diagnosis over grids, lists, random samples and seeds, on every core");
  sub->add_option("SPEC", command->spec, "YAML spec of a study or a diagnosis with a sweep: plan, run and merge it");
  add_request(*sub, *command);
  add_jobs(*sub, *command);
  add_loudness(*sub, command->loudness);
  sub->require_subcommand(0, 1);
  declare_parts(*sub, exit);
  sub->footer(
      "Examples:\n"
      "  bayesctrl sweep configs/exp1.yaml --set 'sweep={grid: {controllers.P1.gain: [1, 3, 10]}}' --out results/gain\n"
      "  bayesctrl sweep plan configs/sensitivity.yaml --out results/s && bayesctrl sweep run results/s --shard 1/2\n"
      "The folder holds manifest.json, results/ (files that are whole or not there) and, merged, table.csv,\n"
      "statistics.csv and summary.json. A sweep that was interrupted goes on with bayesctrl sweep resume DIR.");
  sub->callback([command, sub, &exit] {
    if (!sub->get_subcommands().empty()) return;
    if (command->spec.empty()) throw CLI::RequiredError("SPEC");
    keep_memory();
    const auto [request, folder] = asked(*command);
    const SweepPlan plan = plan_sweep(request, folder);
    if (!command->silent()) print_plan(plan);
    exit = run_and_merge(plan, folder, *command);
  });
}

}  // namespace bayesctrl
