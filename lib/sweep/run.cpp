#include "sweep/run.hpp"

#include <mutex>
#include <optional>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/text.hpp"
#include "numerics/parallel.hpp"
#include "sweep/bundle.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

/// Rows of one run below its number.
Table numbered_rows(const SweepPlan& plan, int run, const fs::path& keep) {
  Table rows = plan.run(run, keep);
  const std::vector<Cell> number(rows.rows(), Cell(std::int64_t{run} + 1));
  rows.columns.insert(rows.columns.begin(), Column{"run", "", number});
  return rows;
}

}  // namespace

Shard parse_shard(const std::string& text) {
  const std::size_t slash = text.find('/');
  const auto index = parse_integer<int>(text.substr(0, slash));
  const auto count = slash == std::string::npos ? std::nullopt : parse_integer<int>(text.substr(slash + 1));
  if (index && count && *index >= 1 && *index <= *count) return {*index, *count};
  throw Error("--shard " + shown(text) + ": write I/N with 1 <= I <= N, e.g. 2/8", ExitCode::usage);
}

SweepRunResult run_sweep(const SweepPlan& plan, const fs::path& folder, const SweepRunOptions& options) {
  SweepRunResult result;
  std::vector<int> missing;
  for (int b = 0; b < plan.bundles(); ++b) {
    if (!options.shard.has(b)) continue;
    result.runs += plan.runs_in(b);
    const BundleText known = read_bundle(plan, folder, b);
    if (known.csv) {
      result.before += plan.runs_in(b);
      continue;
    }
    if (!known.damage.empty()) result.damaged.push_back(bundle_file(plan, folder, b).string() + " " + known.damage);
    missing.push_back(b);
  }
  std::mutex mutex;  // guards the callback and what it counts
  std::size_t seen = result.before;
  const auto stopped = [&] { return options.stop && options.stop(); };
  in_parallel(missing.size(), options.jobs, [&](std::size_t i) {
    const int b = missing[i];
    Table table;
    for (int run = plan.first_of(b); run < plan.end_of(b); ++run) {
      if (stopped()) return;
      append(table,
             numbered_rows(plan, run,
                           options.keep ? folder / "runs" / padded(static_cast<std::size_t>(run) + 1, 6) : fs::path()));
      const std::lock_guard lock(mutex);
      if (options.progress) options.progress(++seen, result.runs);
    }
    write_bundle(plan, folder, b, to_csv(table));
    const std::lock_guard lock(mutex);
    result.done += plan.runs_in(b);
  });
  return result;
}

SweepStatus sweep_status(const SweepPlan& plan, const fs::path& folder) {
  SweepStatus status;
  status.planned = static_cast<std::size_t>(plan.manifest.runs);
  for (int b = 0; b < plan.bundles(); ++b) {
    const BundleText bundle = read_bundle(plan, folder, b);
    const std::string file = bundle_file(plan, folder, b).string();
    if (!bundle.csv) {
      if (!bundle.damage.empty()) status.damaged.push_back(file + " " + bundle.damage);
      status.missing.push_back(b);
      continue;
    }
    status.done += plan.runs_in(b);
    const Table table = parse_csv(*bundle.csv, file);
    const Column *run = table.find("run"), *state = table.find("status"), *reason = table.find("reason");
    for (std::size_t row = 0; row < table.rows(); ++row) {
      ++status.rows;
      if (state->at(row) == Cell(std::string("ok"))) continue;
      ++status.failed;
      const Cell why = reason->at(row);
      const auto* text = std::get_if<std::string>(&why);
      const Cell number = run->at(row);
      status.reasons[text != nullptr ? *text : ""].push_back(static_cast<int>(std::get<std::int64_t>(number)));
    }
  }
  return status;
}

}  // namespace bayesctrl
