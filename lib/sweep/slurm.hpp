#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "sweep/run.hpp"

namespace bayesctrl {

/// How a sweep is given to Slurm.
struct SlurmOptions {
  std::filesystem::path program;        // bayesctrl, as the nodes find it
  int shards = 0;                       // 0: tasks of about five minutes
  int cpus = 1;                         // of each task
  std::vector<std::string> directives;  // lines "#SBATCH ..." of the user's, e.g. --partition=short
  int attempts = 3;                     // how often missing shards are submitted
  std::function<void(const std::string& line)> say;
  std::function<void(std::size_t done, std::size_t total)> progress;
  std::function<bool()> stop;
};

/// The script of the array job and the one that merges, as they are submitted.
struct SlurmScripts {
  std::string array, merge;
};
SlurmScripts slurm_scripts(const SweepPlan& plan, const std::filesystem::path& folder, const SlurmOptions& options);

/// How many shards a sweep is cut into: as asked for, at most one per bundle and what Slurm's MaxArraySize admits.
int slurm_shards(const SweepPlan& plan, const SlurmOptions& options);

/// "1,4-6": Slurm's notation for shards, counted from 1.
std::string array_ranges(const std::vector<int>& shards);

/// Submits an array job of the shards in which something is missing and a merge that depends on it, waits for both, and
/// submits again what is missing then. Where jobs of an earlier call are still in the queue, waits for these. Ends
/// early when `stop` says so; the jobs go on. Throws IoError where Slurm refuses.
void submit_to_slurm(const SweepPlan& plan, const std::filesystem::path& folder, const SlurmOptions& options);

}  // namespace bayesctrl
