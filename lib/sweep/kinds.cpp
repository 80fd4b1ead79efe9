#include "sweep/kinds.hpp"

#include <array>
#include <functional>
#include <new>

#include "base/error.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "experiment/run.hpp"
#include "experiment/tabulate.hpp"
#include "experiment/write.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

ordered_json resolved_study(const Node& spec) { return to_json(read<Study>(spec)); }

std::vector<fs::path> no_inputs(const Node& /*spec*/) { return {}; }

Table run_study(const Node& spec, const SweepPoint& point, const fs::path& keep) {
  auto study = read<Study>(spec);
  study.point = point;
  std::vector<StudyOutcome> outcomes = run_all({std::move(study)}, {.jobs = 1, .progress = {}, .stop = {}});
  if (!keep.empty()) write_results(outcomes.front(), keep, fs::path(spec.where.file).filename().string());
  return summary_table(outcomes.front());
}

ordered_json resolved_diagnosis(const Node& spec) { return to_json(read_diagnosis_spec(spec)); }

std::vector<fs::path> recordings_of(const Node& node) {
  const DiagnosisSpec spec = read_diagnosis_spec(node);
  if (const std::vector<SpecError> missing = missing_files(spec); !missing.empty()) throw missing.front();
  std::vector<fs::path> files;
  for (const auto* list : {&spec.recordings, &spec.held_out}) {
    for (const RecordingFile& recording : *list) {
      files.push_back(recording.file);
      if (!recording.simulation.empty()) files.push_back(recording.simulation);
    }
  }
  return files;
}

/// What a row says of a diagnosis; `d` is null where it failed.
struct DiagnosisColumn {
  const char* name;
  std::function<Cell(const Diagnosis& d)> cell;
};

const std::vector<DiagnosisColumn>& diagnosis_columns() {
  static const std::vector<DiagnosisColumn> list{
      {"verdict", [](const Diagnosis& d) { return Cell(std::string(to_name(d.verdict))); }},
      {"verdict_reason", [](const Diagnosis& d) { return d.reason.empty() ? Cell() : Cell(d.reason); }},
      {"effects",
       [](const Diagnosis& d) {
         std::string text;
         for (const ExplainedEffect& effect : d.explanation.effects) {
           text += (text.empty() ? "" : " + ") + label(effect, d.joints);
         }
         return text.empty() ? Cell() : Cell(text);
       }},
      {"equation",
       [](const Diagnosis& d) { return d.explanation.equation.empty() ? Cell() : Cell(d.explanation.equation); }},
      {"probability", [](const Diagnosis& d) { return Cell(d.explanation.probability); }},
      {"detected", [](const Diagnosis& d) { return Cell(std::int64_t{d.mismatch.detected}); }},
      {"channel",
       [](const Diagnosis& d) {
         return d.mismatch.channel ? Cell(std::string(to_name(*d.mismatch.channel))) : Cell();
       }},
      {"joint", [](const Diagnosis& d) { return d.mismatch.joint ? Cell(std::int64_t{*d.mismatch.joint}) : Cell(); }},
      {"noise_floor", [](const Diagnosis& d) { return Cell(d.fit.noise_floor); }},
      {"train_before", [](const Diagnosis& d) { return optional_number(d.fit.train.before); }},
      {"train_refit", [](const Diagnosis& d) { return optional_number(d.fit.train.refit); }},
      {"train_after", [](const Diagnosis& d) { return optional_number(d.fit.train.after); }},
      {"held_out_before", [](const Diagnosis& d) { return optional_number(d.fit.held_out.before); }},
      {"held_out_refit", [](const Diagnosis& d) { return optional_number(d.fit.held_out.refit); }},
      {"held_out_after", [](const Diagnosis& d) { return optional_number(d.fit.held_out.after); }},
  };
  return list;
}

Table diagnosis_row(const DiagnosisSpec& spec, const SweepPoint& point, const Diagnosis* found,
                    const std::string& reason) {
  std::vector<std::pair<std::string, Cell>> cells{{"experiment", spec.name}};
  cells.insert(cells.end(), point.begin(), point.end());
  cells.emplace_back("status", std::string(found != nullptr ? "ok" : "failed"));
  cells.emplace_back("reason", reason);
  for (const DiagnosisColumn& column : diagnosis_columns()) {
    cells.emplace_back(column.name, found != nullptr ? column.cell(*found) : Cell());
  }
  return one_row(std::move(cells));
}

Table run_diagnosis(const Node& node, const SweepPoint& point, const fs::path& keep) {
  const DiagnosisSpec spec = read_diagnosis_spec(node);
  try {
    const Diagnosed diagnosed = diagnose(spec);
    if (!keep.empty()) write_diagnosis(diagnosed, keep);
    return diagnosis_row(spec, point, &diagnosed.diagnosis, "");
  } catch (const std::bad_alloc&) {
    return diagnosis_row(spec, point, nullptr, "out of memory");
  } catch (const IoError&) {
    throw;  // the machine's fault, which another try may not meet
  } catch (const Error& error) {
    return diagnosis_row(spec, point, nullptr, error.what());
  }
}

constexpr std::array<SweepKind, 2> kKinds{{
    {"study", "run", resolved_study, no_inputs, run_study, false},
    {"diagnosis", "diagnose", resolved_diagnosis, recordings_of, run_diagnosis, true},
}};

}  // namespace

const SweepKind& sweep_kind(std::string_view name) {
  for (const SweepKind& kind : kKinds) {
    if (kind.name == name) return kind;
  }
  throw Error("a sweep repeats a study or a diagnosis, not a " + std::string(name), ExitCode::bad_input);
}

}  // namespace bayesctrl
