#pragma once

#include <functional>
#include <nlohmann/json.hpp>

#include "diagnose/recording/spec.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// What `bayesctrl diagnose` found, as its files are: the contract of diagnosis.json is docs/diagnosis.md.
struct Diagnosis {
  nlohmann::ordered_json json;   // diagnosis.json
  nlohmann::ordered_json model;  // model.yaml: plant, parameters, effects, remainder, signals
  Table missing_torque;          // t, recording, d and its band per joint
  Table fit;                     // measured beside simulated by the nominal and the corrected model
};

/// Told when a stage begins: what part of the work is usually done by then, in %, and the stage's name.
using StageBegins = std::function<void(int percent, std::string_view stage)>;

/// Stages 1 to 8. Throws SpecError, DataError, IoError for what cannot be read, NumericalError for a nominal that
/// cannot be simulated.
Diagnosis diagnose(const DiagnosisSpec& spec, const StageBegins& begins = {});

/// Files of a diagnosis in a folder, all or none.
void write_diagnosis(const Diagnosis& diagnosis, const std::filesystem::path& folder);

}  // namespace bayesctrl
