#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "io/node.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// One column of a recording and how its numbers become SI units: value * scale + offset.
struct Signal {
  std::string column;
  double scale = 1.0;
  double offset = 0.0;
  std::string unit = "";
  bool linear_hold = false;  // of an input: straight from sample to sample
  Location where;
};

/// Which columns mean what.
struct Signals {
  std::optional<Signal> time;  // else `rate`
  double rate = 0.0;           // Hz
  std::vector<Signal> position, velocity, input;
};

struct RecordingFile {
  std::filesystem::path file;  // relative to the working folder
  std::string name;            // as in the spec
  std::optional<double> from, to;
  std::filesystem::path simulation;  // empty: none
  Location where;
};

/// What `bayesctrl diagnose` is asked for.
struct DiagnosisSpec {
  std::string name;
  std::optional<Plant> plant;
  std::vector<std::string> free;
  Signals signals;
  std::vector<RecordingFile> recordings, held_out;
  std::vector<std::size_t> effects;  // indices of EffectForm; all where the spec names none
  double horizon = 1.0;              // s

  int joints() const { return static_cast<int>(signals.position.size()); }
};

/// Throws SpecError and IoError.
DiagnosisSpec read_diagnosis_spec(const std::filesystem::path& path);

/// The part `signals` of a spec.
Signals read_signals(const Node& node);

}  // namespace bayesctrl
