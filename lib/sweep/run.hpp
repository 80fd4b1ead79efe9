#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sweep/plan.hpp"

namespace bayesctrl {

/// Part i of n of a sweep, 1 <= i <= n: every n-th bundle.
struct Shard {
  int index = 1;
  int count = 1;

  bool has(int bundle) const { return bundle % count == index - 1; }
};

/// "i/n". Throws Error (usage) for anything else.
Shard parse_shard(const std::string& text);

struct SweepRunOptions {
  Shard shard;
  int jobs = 0;       // threads; 0: all cores
  bool keep = false;  // each run's own files as well, in DIR/runs/NUMBER
  std::function<void(std::size_t done, std::size_t total)> progress;  // runs of the shard; one call at a time
  std::function<bool()> stop;                                         // asked before each run
};

struct SweepRunResult {
  std::size_t runs = 0;              // of the shard
  std::size_t before = 0;            // of them, done before
  std::size_t done = 0;              // of them, now
  std::vector<std::string> damaged;  // files of results that were not valid and were made again
};

/// Runs what is missing of a shard. Tables depend neither on `jobs` nor on how a sweep is cut into shards. Harmless
/// where other processes work in the same folder: they write the same bytes. Throws IoError.
SweepRunResult run_sweep(const SweepPlan& plan, const std::filesystem::path& folder, const SweepRunOptions& options);

/// What a sweep's folder holds.
struct SweepStatus {
  std::size_t planned = 0, done = 0;                // runs
  std::size_t rows = 0, failed = 0;                 // of the runs that are done: a study has a row for each controller
  std::map<std::string, std::vector<int>> reasons;  // of failures: numbers of their runs, from 1
  std::vector<std::string> damaged;                 // files that count as missing, and why
  std::vector<int> missing;                         // bundles
};
SweepStatus sweep_status(const SweepPlan& plan, const std::filesystem::path& folder);

}  // namespace bayesctrl
