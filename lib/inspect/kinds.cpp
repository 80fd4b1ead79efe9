#include "inspect/kinds.hpp"

#include <algorithm>
#include <array>

#include "base/format.hpp"
#include "bench/bench.hpp"
#include "diagnose/recording/read_recording.hpp"
#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/simulate_model.hpp"
#include "experiment/calibrate.hpp"
#include "experiment/check.hpp"
#include "experiment/read.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"
#include "spec/sweep.hpp"
#include "sweep/sensitivity.hpp"
#include "trial/trial.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

/// Three for each key that T has, one for each that is nearly one of them, less three for each other and one for each
/// that T needs and is not there.
template <HasFields T>
int affinity_to(const Node& spec) {
  std::vector<std::string_view> known, given;
  for (const Node::Entry& entry : spec.entries) given.push_back(entry.key);
  int score = 0;
  const auto has = [](const std::vector<std::string_view>& list, std::string_view key) {
    return std::find(list.begin(), list.end(), key) != list.end();
  };
  T defaults{};
  T::fields(defaults, [&](std::string_view key, auto&, const Info& info) {
    known.push_back(key);
    if (info.required && !has(given, key) && nearest(key, given).empty()) --score;
  });
  for (const std::string_view key : given) score += has(known, key) ? 3 : nearest(key, known).empty() ? -3 : 1;
  return score;
}

template <HasFields T>
ordered_json schema_of() {
  return schema<T>();
}

std::string count(std::size_t number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

std::string study_summary(const Node& spec) {
  const std::vector<Study> studies = read_studies(spec);
  return "study '" + studies.front().name + "', " + count(studies.front().controllers.items.size(), "controller") +
         (studies.size() > 1 ? ", sweep of " + std::to_string(studies.size()) + " points" : "");
}

DiagnosisSpec read_one_diagnosis(const Node& node) { return read_diagnosis_spec(node); }

ordered_json diagnosis_schema() {
  ordered_json result = schema<DiagnosisSpec>();
  result["properties"]["sweep"] = sweep_schema();
  return result;
}

/// A spec may be checked where its recordings are not.
std::string not_there(const DiagnosisSpec& spec) {
  std::string text;
  for (const SpecError& missing : missing_files(spec)) text += std::string("\n  but ") + missing.what();
  return text;
}

/// The recordings that are there, opened as diagnose opens them: how much they hold. Throws what it throws.
std::string opened(const DiagnosisSpec& spec) {
  std::size_t samples = 0, left_out = 0;
  double seconds = 0.0;
  for (const std::vector<RecordingFile>* files : {&spec.recordings, &spec.held_out}) {
    for (const RecordingFile& file : *files) {
      if (!std::filesystem::exists(file.file)) continue;
      const Measured measured = read_recording(file, spec.signals);
      if (std::filesystem::exists(file.simulation)) read_simulation(file, spec.signals, measured);
      samples += measured.samples();
      left_out += measured.left_out;
      seconds += measured.time.back();
    }
  }
  if (samples == 0) return "";
  const std::string pieces =
      left_out == 0 ? "" : " in pieces, of " + std::to_string(samples + left_out) + " that are there,";
  return ", " + count(samples, "sample") + pieces + " in " + format(seconds, 3) + " s";
}

/// The first point of a diagnosis, after all were read. A spec without a sweep is its only point.
DiagnosisSpec first_diagnosis(Node node, std::size_t* points = nullptr) {
  const Sweep sweep = take_sweep(node);
  const std::uint64_t seed = sweep.given ? seed_of(node) : 1;
  for (std::size_t i = sweep.size(); i-- > 1;) sweep.read_at(node, sweep.point(i, seed), read_one_diagnosis);
  if (points != nullptr) *points = sweep.size();
  return sweep.read_at(node, sweep.point(0, seed), read_one_diagnosis);
}

std::string diagnosis_summary(const Node& node) {
  std::size_t points = 1;
  const DiagnosisSpec spec = first_diagnosis(node, &points);
  const std::string swept = points > 1 ? ", sweep of " + std::to_string(points) + " points" : "";
  return "diagnosis '" + spec.name + "', " + count(spec.recordings.size(), "recording") + ", " +
         std::to_string(spec.held_out.size()) + " held out, " + count(spec.effects.size(), "effect") + swept +
         opened(spec) + not_there(spec);
}

std::string model_summary(const Node& node) {
  const ModelFile file = read_model_file(node);
  return "model '" + file.name + "', " + std::string(name_of(file.model.plant)) + " with " +
         count(file.model.effects.size(), "effect");
}

std::string trial_summary(const Node& node) {
  const auto spec = read<TrialSpec>(node);
  return "trial '" + spec.name + "', seed " + std::to_string(spec.seed);
}

std::string bench_summary(const Node& node) {
  const Bench bench = read_bench(node);
  return "bench '" + bench.name + "', " + count(bench.machines.size(), "machine");
}

std::string calibration_summary(const Node& node) {
  const Calibration spec = read_calibration(node);
  return "calibration of " + spec.study + ", " + count(spec.vary.items.size(), "setting");
}

std::string sensitivity_summary(const Node& node) {
  const Sensitivity spec = read_sensitivity(node);
  return "sensitivity of " + count(spec.claims.size(), "claim") + ", " + std::to_string(spec.count) + " draws of " +
         count(spec.experiments.items.size(), "experiment");
}

std::string published_summary(const Node& node) {
  const auto table = read<PublishedTable>(node);
  return "published table '" + table.name + "', " + count(table.cells.size(), "cell");
}

template <class T>
std::string resolved_as(const Node& node) {
  return to_yaml(to_json(read<T>(node)));
}

const std::array<SpecKind, 8>& kinds() {
  static const std::array<SpecKind, 8> list{{
      {"study", "run, simulate: a machine, a task, controllers", study_schema, affinity_to<Study>, study_summary,
       study_yaml},
      {"diagnosis", "diagnose: a nominal model and recordings", diagnosis_schema, affinity_to<DiagnosisSpec>,
       diagnosis_summary, [](const Node& node) { return to_yaml(to_json(first_diagnosis(node))) + sweep_yaml(node); }},
      {"model", "simulate, model: {file: ...}: what diagnose found", schema_of<ModelFile>, affinity_to<ModelFile>,
       model_summary, resolved_as<ModelFile>},
      {"trial", "trial: how many machines with which concealed effects", schema_of<TrialSpec>, affinity_to<TrialSpec>,
       trial_summary, resolved_as<TrialSpec>},
      {"bench", "bench: real machines and what is known of them", schema_of<Bench>, affinity_to<Bench>, bench_summary,
       resolved_as<Bench>},
      {"calibration", "calibrate: settings to search for", schema_of<Calibration>, affinity_to<Calibration>,
       calibration_summary, resolved_as<Calibration>},
      {"sensitivity", "sensitivity: claims under uncertain settings", schema_of<Sensitivity>, affinity_to<Sensitivity>,
       sensitivity_summary, resolved_as<Sensitivity>},
      {"published_table", "table, check: published numbers and tolerances", schema_of<PublishedTable>,
       affinity_to<PublishedTable>, published_summary, resolved_as<PublishedTable>},
  }};
  return list;
}

}  // namespace

std::span<const SpecKind> spec_kinds() { return kinds(); }

const SpecKind* find_kind(std::string_view name) {
  const auto found = std::find_if(kinds().begin(), kinds().end(), [&](const SpecKind& k) { return k.name == name; });
  return found == kinds().end() ? nullptr : &*found;
}

const SpecKind& kind_of(const Node& spec) {
  detail::require_map(spec, "the spec");
  const auto better = [&](const SpecKind& a, const SpecKind& b) { return a.affinity(spec) < b.affinity(spec); };
  return *std::max_element(kinds().begin(), kinds().end(), better);
}

void require_kind(const Node& spec, std::string_view name) {
  constexpr int kClearly = 6;  // two keys that only the other kind has
  if (spec.kind != Node::Kind::map) return;
  const SpecKind &meant = *find_kind(name), &is = kind_of(spec);
  if (is.affinity(spec) < meant.affinity(spec) + kClearly) return;
  const auto in_words = [](std::string text) {
    std::replace(text.begin(), text.end(), '_', ' ');
    return text;
  };
  throw SpecError({spec.where.file}, "is a " + in_words(std::string(is.name)) + ", not a " +
                                         in_words(std::string(name)) + ": it is for bayesctrl " +
                                         std::string(is.text.substr(0, is.text.find(':'))));
}

}  // namespace bayesctrl
