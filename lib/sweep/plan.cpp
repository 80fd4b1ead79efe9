#include "sweep/plan.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/from_json.hpp"
#include "io/hash.hpp"
#include "io/json.hpp"
#include "io/provenance.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr double kBundleSeconds = 1.0;       // of work in one file of results: what a kill may cost each thread
constexpr double kShortBundleSeconds = 0.1;  // but this where bundles would be few: writing one takes milliseconds
constexpr int kFewBundles = 64;
constexpr std::size_t kMostInputBytes = std::size_t{1} << 32;

/// Spec, sweep and kind of a manifest's text.
SweepPlan read_plan(SweepManifest manifest, const std::string& text) {
  SweepPlan plan;
  plan.kind = &sweep_kind(manifest.kind);
  plan.spec = parse_yaml(text, manifest.spec);
  for (const std::string& assignment : manifest.assignments) set_path(plan.spec, assignment);
  plan.sweep_text = sweep_yaml(plan.spec);
  plan.sweep = take_sweep(plan.spec);
  plan.manifest = std::move(manifest);
  return plan;
}

ordered_json resolved(const SweepPlan& plan, const SweepPoint& point) {
  return plan.sweep.read_at(plan.spec, point, [&](const Node& node) { return plan.kind->resolved(node); });
}

/// What the first run and the sweep say is all that the spec says: what a sweep sets, it sets in every run.
std::string hash_of(const SweepPlan& plan) {
  const SweepManifest& manifest = plan.manifest;
  const SweepPoint first = plan.sweep.point(0, seed_of(plan.spec));
  ordered_json object{{"kind", manifest.kind}, {"limit", manifest.limit}, {"inputs", to_json(manifest.inputs)}};
  object["first"] = resolved(plan, first);
  object["seed"] = seed_of(plan.spec);
  object["sweep"] = plan.sweep_text;
  return sha256(object.dump(-1, ' ', false, ordered_json::error_handler_t::replace));
}

/// Checks every run's spec and chooses those that the constraints admit.
void choose_runs(SweepPlan& plan) {
  SweepManifest& manifest = plan.manifest;
  manifest.points = static_cast<int>(plan.sweep.size());
  const std::uint64_t seed = seed_of(plan.spec);
  std::vector<char> admitted(plan.sweep.size(), 1);
  const auto check = [&](std::size_t i) {
    const ordered_json spec = resolved(plan, plan.sweep.point(i, seed));
    admitted[i] = plan.sweep.admits(spec) ? 1 : 0;
  };
  check(0);  // a mistake in all of them is told of the first
  in_parallel(admitted.size(), 0, check);
  std::vector<int> kept;
  for (std::size_t i = 0; i < admitted.size(); ++i) {
    if (admitted[i]) kept.push_back(static_cast<int>(i));
  }
  plan.sweep.require_some(kept.size());
  const std::size_t limit = manifest.limit > 0 ? static_cast<std::size_t>(manifest.limit) : kept.size();
  kept.resize(std::min(kept.size(), limit));
  manifest.runs = static_cast<int>(kept.size());
  manifest.kept.clear();
  if (!plan.sweep.constraints.empty()) manifest.kept = std::move(kept);
}

std::vector<SweepInput> inputs_of(const SweepPlan& plan) {
  std::vector<SweepInput> inputs;
  const std::uint64_t seed = seed_of(plan.spec);
  std::vector<fs::path> files;
  for (std::size_t i = 0; i < plan.sweep.size(); ++i) {  // a sweep may go over recordings
    const std::vector<fs::path> own =
        plan.sweep.read_at(plan.spec, plan.sweep.point(i, seed), [&](const Node& n) { return plan.kind->inputs(n); });
    if (own.empty()) break;
    files.insert(files.end(), own.begin(), own.end());
  }
  std::sort(files.begin(), files.end());
  files.erase(std::unique(files.begin(), files.end()), files.end());
  for (const fs::path& file : files) {
    inputs.push_back({fs::absolute(file).lexically_normal().string(), sha256(read_file(file, kMostInputBytes))});
  }
  return inputs;
}

void time_first_run(SweepPlan& plan) {
  const auto begin = std::chrono::steady_clock::now();
  plan.run(0, {});
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  plan.manifest.seconds_per_run = seconds;
  const double most = std::max(kShortBundleSeconds / seconds, static_cast<double>(plan.manifest.runs) / kFewBundles);
  plan.manifest.bundle = static_cast<int>(std::clamp(std::floor(kBundleSeconds / seconds), 1.0, std::max(1.0, most)));
}

SweepManifest read_manifest(const fs::path& folder) {
  const fs::path file = folder / SweepManifest::kFile;
  if (!fs::exists(file)) {
    throw DataError({folder.string()},
                    "is no planned sweep: it has no manifest.json; make one with bayesctrl sweep plan");
  }
  auto manifest = from_json<SweepManifest>(read_json(file), file.string());
  if (manifest.format != SweepManifest::kFormat) {
    throw DataError({file.string()}, "has format " + std::to_string(manifest.format) + ", this program knows " +
                                         std::to_string(SweepManifest::kFormat));
  }
  const auto possible = static_cast<std::size_t>(std::max(manifest.runs, 0));
  if (manifest.runs < 1 || manifest.bundle < 1 || (!manifest.kept.empty() && manifest.kept.size() != possible)) {
    throw DataError({file.string()}, "is damaged: its numbers contradict each other");
  }
  return manifest;
}

void require_unchanged(const SweepPlan& plan, const fs::path& folder) {
  const SweepManifest& manifest = plan.manifest;
  const Location file{(folder / SweepManifest::kFile).string()};
  if (manifest.revision != program_revision()) {
    throw DataError(file, "was planned by revision " + manifest.revision + " of the program, this is " +
                              program_revision() + ": their numbers may differ; plan anew in another folder");
  }
  if (hash_of(plan) != manifest.hash) {
    throw DataError(file, "is damaged: its spec is not the one that was planned");
  }
  if (fs::exists(manifest.spec)) {
    const std::string text = read_file(manifest.spec, kMaxSpecBytes);
    if (text != manifest.text && hash_of(read_plan(manifest, text)) != manifest.hash) {
      throw DataError({manifest.spec}, "has changed since the sweep in " + folder.string() +
                                           " was planned: plan anew in another folder, or undo the change");
    }
  }
  for (const SweepInput& input : manifest.inputs) {
    if (sha256(read_file(input.file, kMostInputBytes)) == input.sha256) continue;
    throw DataError({input.file}, "has changed since the sweep in " + folder.string() +
                                      " was planned: plan anew in another folder, or undo the change");
  }
}

}  // namespace

SweepPoint SweepPlan::point(int run) const {
  const int index = manifest.kept.empty() ? run : manifest.kept[static_cast<std::size_t>(run)];
  return sweep.point(static_cast<std::size_t>(index), seed_of(spec));
}

Table SweepPlan::run(int number, const fs::path& keep) const {
  const SweepPoint settings = point(number);
  return sweep.read_at(spec, settings, [&](const Node& node) { return kind->run(node, settings, keep); });
}

SweepPlan plan_sweep(const SweepRequest& request, const fs::path& folder) {
  SweepManifest manifest;
  manifest.version = program_version();
  manifest.revision = program_revision();
  manifest.kind = request.kind;
  manifest.spec = fs::absolute(request.spec).lexically_normal().string();
  manifest.text = read_file(request.spec, kMaxSpecBytes);
  manifest.assignments = request.assignments;
  manifest.limit = request.limit;
  SweepPlan plan = read_plan(manifest, manifest.text);
  if (const Node::Entry* name = plan.spec.find("name")) plan.manifest.name = name->value.text;
  plan.manifest.inputs = inputs_of(plan);
  plan.manifest.hash = hash_of(plan);
  if (fs::exists(folder / SweepManifest::kFile)) {
    SweepPlan known = open_sweep(folder);
    if (known.manifest.hash == plan.manifest.hash) return known;
    throw DataError({folder.string()}, "holds another sweep, of " + known.manifest.spec +
                                           (known.manifest.spec == plan.manifest.spec ? " with other settings" : "") +
                                           ": choose another folder");
  }
  choose_runs(plan);
  time_first_run(plan);
  write_file(folder / SweepManifest::kFile, to_json(plan.manifest).dump(2) + "\n");
  return plan;
}

SweepPlan read_sweep(const fs::path& folder) {
  const SweepManifest manifest = read_manifest(folder);
  return read_plan(manifest, manifest.text);
}

SweepPlan open_sweep(const fs::path& folder) {
  SweepPlan plan = read_sweep(folder);
  require_unchanged(plan, folder);
  return plan;
}

}  // namespace bayesctrl
