#pragma once

#include <functional>

#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// A diagnosis and what stands beside it in its folder.
struct Diagnosed {
  Diagnosis diagnosis;           // diagnosis.json
  nlohmann::ordered_json model;  // model.yaml: plant, parameters, effects, remainder, signals; null without
  Table missing_torque;          // recording, t, d with its band and what explains it, per joint
  Table runs;                    // fit.csv: measured beside simulated by the nominal and the corrected model
};

/// Told when a stage begins: what part of the work is usually done by then, in %, and the stage's name.
using StageBegins = std::function<void(int percent, std::string_view stage)>;

/// Stages 1 to 8. Throws SpecError, DataError, IoError for what cannot be read, NumericalError for a nominal that
/// cannot be simulated.
Diagnosed diagnose(const DiagnosisSpec& spec, const StageBegins& begins = {});

/// Files of a diagnosis in a folder, all or none.
void write_diagnosis(const Diagnosed& diagnosed, const std::filesystem::path& folder);

/// Where it comes from, beside them: the spec that was read from `file`, the diagnosis' settings, the program.
void write_origin(const DiagnosisSpec& spec, const std::filesystem::path& file, const std::filesystem::path& folder);

}  // namespace bayesctrl
