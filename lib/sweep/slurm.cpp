#include "sweep/slurm.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <set>
#include <sstream>
#include <thread>

#include "base/error.hpp"
#include "io/files.hpp"
#include "io/text.hpp"
#include "sweep/bundle.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using std::chrono::milliseconds;

constexpr double kShardSeconds = 300.0;  // of a task: submitting and starting one takes up to 0.2 s
constexpr int kDefaultArraySize = 1001;  // Slurm's own default of MaxArraySize
constexpr milliseconds kFirstPoll{500}, kLongestPoll{10'000};
constexpr int kSilentPolls = 30;  // failures of squeue in a row that are taken for a restart of its server

struct Said {
  int status = 0;
  std::string text;  // both streams
};

Said ask(const std::string& command) {
  FILE* pipe = ::popen((command + " 2>&1").c_str(), "r");
  if (pipe == nullptr) throw IoError("cannot run " + command);
  Said said;
  std::array<char, 4096> buffer{};
  while (const std::size_t count = std::fread(buffer.data(), 1, buffer.size(), pipe)) {
    said.text.append(buffer.data(), count);
  }
  said.status = ::pclose(pipe);
  return said;
}

std::string one_line(std::string text) {
  while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
  return shown(text, 300);
}

fs::path slurm_folder(const fs::path& folder) { return fs::absolute(folder).lexically_normal() / "slurm"; }

std::string head(const SweepPlan& plan, const SlurmOptions& options, const std::string& what) {
  std::string text = "#!/bin/bash\n#SBATCH --job-name=" + slug(plan.manifest.name) + "-" + what + "\n";
  for (const std::string& line : options.directives) text += "#SBATCH " + line + "\n";
  return text;
}

int max_array_size() {
  const Said said = ask("scontrol show config");
  const std::size_t at = said.text.find("MaxArraySize");
  const std::size_t digits = said.text.find_first_of("0123456789", at);
  if (said.status != 0 || at == std::string::npos || digits == std::string::npos) return kDefaultArraySize;
  return std::max(2, std::atoi(said.text.c_str() + digits));
}

/// Shards in which a bundle is missing.
std::vector<int> missing_shards(const SweepStatus& status, int shards) {
  std::set<int> list;
  for (const int bundle : status.missing) list.insert(bundle % shards + 1);
  return {list.begin(), list.end()};
}

/// Number of the job that sbatch made of a script in `place`, beside which its log will stand.
std::string submit(const fs::path& place, const std::string& script, const std::string& log, const std::string& more) {
  const Said said = ask("sbatch --parsable --output=" + shell_quoted((place / log).string()) + " " + more + " " +
                        shell_quoted((place / script).string()));
  const std::string id = said.text.substr(0, said.text.find_first_of(";\n"));
  if (said.status == 0 && parse_integer<long>(id)) return id;
  throw IoError("sbatch refused the job: " + one_line(said.text) +
                " (--engine local runs the sweep on this machine, without Slurm)");
}

/// Which of these jobs are still in the queue. Nothing where the queue cannot be asked.
std::optional<std::vector<std::string>> in_queue(const std::vector<std::string>& jobs) {
  if (jobs.empty()) return jobs;
  const Said said = ask("squeue --noheader --format=%F");  // of an array the number of the whole
  if (said.status != 0) return std::nullopt;
  std::istringstream lines(said.text);
  std::set<std::string> queued;
  for (std::string line; std::getline(lines, line);) {
    line.erase(std::remove(line.begin(), line.end(), ' '), line.end());
    queued.insert(line);
  }
  std::vector<std::string> list;
  for (const std::string& job : jobs) {
    if (queued.contains(job)) list.push_back(job);
  }
  return list;
}

/// Jobs of an earlier call, as DIR/slurm/jobs has them.
std::vector<std::string> earlier_jobs(const fs::path& folder) {
  const fs::path file = slurm_folder(folder) / "jobs";
  if (!fs::exists(file)) return {};
  std::istringstream words(read_file(file, 1 << 20));
  std::vector<std::string> jobs;
  for (std::string word; words >> word;) jobs.push_back(word);
  return jobs;
}

bool stopped(const SlurmOptions& options) { return options.stop && options.stop(); }

/// Waits until none of the jobs is in the queue.
void await(const std::vector<std::string>& jobs, const SweepPlan& plan, const fs::path& folder,
           const SlurmOptions& options) {
  milliseconds pause = kFirstPoll;
  int silent = 0;
  while (!stopped(options)) {
    const auto queued = in_queue(jobs);
    if (queued && queued->empty()) return;
    silent = queued ? 0 : silent + 1;
    if (silent == kSilentPolls) throw IoError("squeue does not answer; bayesctrl sweep submit waits again");
    if (options.progress) {
      std::size_t done = 0;
      for (int b = 0; b < plan.bundles(); ++b) {
        if (fs::exists(bundle_file(plan, folder, b))) done += plan.runs_in(b);
      }
      options.progress(done, static_cast<std::size_t>(plan.manifest.runs));
    }
    for (milliseconds waited{0}; waited < pause && !stopped(options); waited += milliseconds(100)) {
      std::this_thread::sleep_for(milliseconds(100));
    }
    pause = std::min(pause * 5 / 4, kLongestPoll);
  }
}

}  // namespace

int slurm_shards(const SweepPlan& plan, const SlurmOptions& options) {
  const double seconds = plan.manifest.seconds_per_run * plan.manifest.runs / std::max(1, options.cpus);
  const int wanted = options.shards > 0 ? options.shards : static_cast<int>(std::ceil(seconds / kShardSeconds));
  return std::clamp(wanted, 1, std::min(plan.bundles(), max_array_size() - 1));
}

std::string array_ranges(const std::vector<int>& shards) {
  std::string text;
  for (std::size_t i = 0; i < shards.size();) {
    std::size_t end = i;
    while (end + 1 < shards.size() && shards[end + 1] == shards[end] + 1) ++end;
    text += (text.empty() ? "" : ",") + std::to_string(shards[i]);
    if (end > i) text += "-" + std::to_string(shards[end]);
    i = end + 1;
  }
  return text;
}

SlurmScripts slurm_scripts(const SweepPlan& plan, const fs::path& folder, const SlurmOptions& options) {
  const std::string place = shell_quoted(fs::absolute(folder).lexically_normal().string());
  const std::string program = shell_quoted(options.program.string());
  SlurmScripts scripts;
  scripts.array =
      head(plan, options, "sweep") + "#SBATCH --requeue\n#SBATCH --cpus-per-task=" + std::to_string(options.cpus) +
      "\nexec " + program + " sweep run " + place + " --shard \"$SLURM_ARRAY_TASK_ID\"/" +
      std::to_string(slurm_shards(plan, options)) + " --jobs " + std::to_string(options.cpus) + " --quiet\n";
  scripts.merge = head(plan, options, "merge") + "exec " + program + " sweep merge " + place + " --partial\n";
  return scripts;
}

void submit_to_slurm(const SweepPlan& plan, const fs::path& folder, const SlurmOptions& options) {
  const fs::path place = slurm_folder(folder);
  const auto say = [&](const std::string& line) {
    if (options.say) options.say(line);
  };
  if (const auto queued = in_queue(earlier_jobs(folder)); queued && !queued->empty()) {
    say("jobs of an earlier call are in the queue: waiting for them");
    await(*queued, plan, folder, options);
  }
  for (int attempt = 1; attempt <= options.attempts && !stopped(options); ++attempt) {
    const SweepStatus status = sweep_status(plan, folder);
    if (status.missing.empty()) break;
    const SlurmScripts scripts = slurm_scripts(plan, folder, options);
    const std::vector<int> shards = missing_shards(status, slurm_shards(plan, options));
    write_file(place / "array.sh", scripts.array);
    write_file(place / "merge.sh", scripts.merge);
    const std::string array = submit(place, "array.sh", "%A_%a.log", "--array=" + array_ranges(shards));
    const std::string merge = submit(place, "merge.sh", "%A.log", "--dependency=afterany:" + array);
    write_file(place / "jobs", array + " " + merge + "\n");
    say("array job " + array + ": " + std::to_string(shards.size()) + (shards.size() == 1 ? " shard (" : " shards (") +
        array_ranges(shards) + "), merged by job " + merge);
    await({array, merge}, plan, folder, options);
  }
}

}  // namespace bayesctrl
