#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "spec/sweep.hpp"
#include "sweep/kinds.hpp"

namespace bayesctrl {

/// A file whose content the results of a sweep depend on.
struct SweepInput {
  std::string file;  // absolute
  std::string sha256;

  static void fields(auto& self, auto&& field) {
    field("file", self.file, {.text = "absolute", .required = true});
    field("sha256", self.sha256, {.text = "of its content", .required = true});
  }
  bool operator==(const SweepInput&) const = default;
};

/// manifest.json of a sweep's folder: all that its runs depend on.
struct SweepManifest {
  static constexpr const char* kFile = "manifest.json";
  static constexpr int kFormat = 1;
  int format = kFormat;
  std::string version, revision;
  std::string kind, name, spec, text;
  std::vector<std::string> assignments;
  std::vector<SweepInput> inputs;
  int limit = 0, points = 0, runs = 0;
  std::vector<int> kept;
  int bundle = 1;
  double seconds_per_run = 0.0;
  std::string hash;

  static void fields(auto& self, auto&& field) {
    field("format", self.format, {.text = "of the folder", .required = true});
    field("version", self.version, {.text = "of the program", .required = true});
    field("revision", self.revision, {.text = "of the program", .required = true});
    field("kind", self.kind, {.text = "study or diagnosis", .required = true});
    field("name", self.name, {.text = "of the spec", .required = true});
    field("spec", self.spec, {.text = "absolute path of the spec", .required = true});
    field("text", self.text, {.text = "the spec as it was read", .required = true});
    field("assignments", self.assignments, {.text = "of --set", .required = true});
    field("inputs", self.inputs, {.text = "files that are read", .required = true});
    field("limit", self.limit, {.text = "largest number of runs; 0: none", .required = true});
    field("points", self.points, {.text = "of the sweep, before its constraints", .required = true});
    field("runs", self.runs, {.text = "that are planned", .required = true});
    field("kept", self.kept, {.text = "where there are constraints: points that are run", .required = true});
    field("bundle", self.bundle, {.text = "runs whose results stand in one file", .required = true});
    field("seconds_per_run", self.seconds_per_run, {.text = "as the first took", .required = true});
    field("hash", self.hash, {.text = "SHA-256 of the resolved spec, sweep, inputs and limit", .required = true});
  }
};

/// A planned sweep. Its runs are counted from 0; run r of the plan is row `run` = r + 1 of the table.
struct SweepPlan {
  SweepManifest manifest;
  Node spec;  // without its sweep
  Sweep sweep;
  std::string sweep_text;  // as it is written
  const SweepKind* kind = nullptr;

  SweepPoint point(int run) const;
  Table run(int run, const std::filesystem::path& keep) const;

  int bundles() const { return (manifest.runs + manifest.bundle - 1) / manifest.bundle; }
  int first_of(int bundle) const { return bundle * manifest.bundle; }
  int end_of(int bundle) const { return std::min(manifest.runs, (bundle + 1) * manifest.bundle); }
  std::size_t runs_in(int bundle) const { return static_cast<std::size_t>(end_of(bundle) - first_of(bundle)); }
};

/// What a sweep is planned from.
struct SweepRequest {
  std::filesystem::path spec;
  std::string kind;
  std::vector<std::string> assignments;  // of --set
  int limit = 0;                         // 0: all
};

/// Reads every run's spec strictly, times the first run, and writes manifest.json. A folder that was planned from the
/// same spec stays as it is. Throws SpecError, DataError or IoError, also where the folder is another sweep's.
SweepPlan plan_sweep(const SweepRequest& request, const std::filesystem::path& folder);

/// A planned folder as it is, to look at and to merge what is there. Throws DataError where the manifest is damaged.
SweepPlan read_sweep(const std::filesystem::path& folder);

/// A planned folder that is to be worked on. Throws DataError where the manifest is damaged, where the spec or a
/// recording has changed since, or where another revision of the program planned it.
SweepPlan open_sweep(const std::filesystem::path& folder);

}  // namespace bayesctrl
