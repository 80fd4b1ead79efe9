#pragma once

#include <array>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/fields.hpp"
#include "diagnose/recording/unit.hpp"
#include "io/node.hpp"
#include "io/schema.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// What an input does between two samples.
enum class Hold { zero_order, linear };
constexpr std::array<std::string_view, 2> names(Hold) { return {"zero_order", "linear"}; }

/// One column of a recording and how its numbers become SI units: value * scale + offset is in `unit`.
struct Signal {
  static constexpr std::string_view kShort = "column";
  std::string column;
  double scale = 1.0;
  double offset = 0.0;
  std::string unit = "";
  Hold hold = Hold::zero_order;  // of an input
  Location where;

  static void fields(auto& self, auto&& field) {
    field("column", self.column, {.text = "the column's name in the file", .required = true});
    field("scale", self.scale, {.text = "what its numbers are multiplied with to be in the unit"});
    field("offset", self.offset, {.text = "what is added after that"});
    field("unit", self.unit, {.text = "the unit after scale and offset, converted to SI: deg, mm, ms, mN m, rpm, ..."});
  }
  std::string problem() const {
    if (scale == 0.0) return "scale = 0 leaves nothing of the signal";
    if (unit.empty() || find_unit(unit) != nullptr) return "";
    return "unit '" + unit + "' is not known; known are " + known_units();
  }
  /// What turns numbers of the column into SI units.
  auto to_si() const {
    const Unit* known = find_unit(unit);
    const double in_unit = known != nullptr ? known->scale : 1.0, zero = known != nullptr ? known->offset : 0.0;
    return [scale = scale, offset = offset, in_unit, zero](double value) {
      return (value * scale + offset) * in_unit + zero;
    };
  }
};

struct PositionSignal : Signal {
  bool unwrap = false;
  static void fields(auto& self, auto&& field) {
    Signal::fields(self, field);
    field("unwrap", self.unwrap, {.text = "jumps by a whole turn from one sample to the next are taken out"});
  }
};

struct InputSignal : Signal {
  static void fields(auto& self, auto&& field) {
    Signal::fields(self, field);
    field("hold", self.hold, {.text = "between two samples: the first one's value, or straight to the second"});
  }
};

/// A column, or where there is none the samples' rate.
struct Clock {
  std::optional<Signal> column;
  double rate = 0.0;  // Hz
};

/// Which columns mean what.
struct Signals {
  Clock time;
  std::vector<PositionSignal> position;
  std::vector<Signal> velocity;
  std::vector<InputSignal> input;
  std::vector<Signal> temperature;

  static void fields(auto& self, auto&& field) {
    field("time", self.time, {.text = "a column, or {rate: samples per second}", .required = true});
    field("position", self.position, {.text = "a column, or one per joint", .required = true});
    field("velocity", self.velocity, {.text = "a column, or one per joint; not needed"});
    field("input", self.input, {.text = "a column, or one per joint", .required = true});
    field("temperature", self.temperature,
          {.text = "a column, or one per joint; not needed. Rows in which it is missing are passed over"});
  }
};

struct RecordingFile {
  static constexpr std::string_view kShort = "file";
  std::filesystem::path file;  // relative to the working folder
  std::string name;            // as in the spec
  std::optional<double> from, to;
  std::filesystem::path simulation;  // relative to the working folder; empty: none
  std::string simulation_name;       // as in the spec
  Location where;

  static void fields(auto& self, auto&& field) {
    field("file", self.name, {.text = "a CSV or MAT file, relative to the spec", .required = true});
    field("from", self.from, {kAny, "s", "rows before this time are left out"});
    field("to", self.to, {kAny, "s", "rows after this time are left out"});
    field("simulation", self.simulation_name, {.text = "what the user's own simulator said, with the same columns"});
  }
  std::string problem() const {
    if (name.empty()) return "file is empty: it names a CSV or MAT file";
    return from && to && *from >= *to ? "from must be before to" : "";
  }
  /// Whether a row of that time is part of it; one without a time is.
  bool holds(double time) const { return !(from && time < *from) && !(to && time > *to); }
};

/// Effects of the catalogue by their place in it; in specs a list of names.
struct EffectNames : std::vector<std::size_t> {
  using std::vector<std::size_t>::vector;
  static EffectNames usual();
};

/// The model that is doubted: in specs a model and, among its keys, `free`.
struct NominalModel {
  std::optional<Plant> plant;
  std::vector<std::string> free;  // parameters that may be re-estimated
};

/// What `bayesctrl diagnose` is asked for.
struct DiagnosisSpec {
  std::string name;
  NominalModel model;
  Signals signals;
  std::vector<RecordingFile> recordings, held_out;
  EffectNames effects = EffectNames::usual();
  double horizon = 1.0;  // s
  Location horizon_at;   // where it is set

  int joints() const { return static_cast<int>(signals.position.size()); }

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "any text; folder names are made of it", .required = true});
    field("model", self.model, {.text = "the simulation's model; 'free' names parameters that may be re-estimated"});
    field("signals", self.signals, {.text = "which columns mean what", .required = true});
    field("recordings", self.recordings, {.text = "what is to be explained", .required = true});
    field("held_out", self.held_out, {.text = "recordings that are not touched before the last step"});
    field("effects", self.effects,
          {.text = "what may be named as missing; `usual` stands for every effect but those that have to be asked for "
                   "(list effects), and is what is looked for without it"});
    field("horizon_s", self.horizon, {kPositive, "s", "window of the free runs that the fit reports"});
  }
};

/// The notations of these types, for io/read.hpp, io/emit.hpp and io/schema.hpp.
void read_value(const Node& node, Clock& clock);
void read_value(const Node& node, Signals& signals);
void read_value(const Node& node, EffectNames& effects);
void read_value(const Node& node, NominalModel& nominal);
nlohmann::ordered_json json_value(const Clock& clock);
nlohmann::ordered_json json_value(const EffectNames& effects);
nlohmann::ordered_json json_value(const NominalModel& nominal);
nlohmann::ordered_json schema_value(const Clock*, detail::Definitions& definitions);
nlohmann::ordered_json schema_value(const EffectNames*, detail::Definitions& definitions);
nlohmann::ordered_json schema_value(const NominalModel*, detail::Definitions& definitions);

/// Files of the spec are relative to the folder of the file that it was read from. Throws SpecError and IoError.
DiagnosisSpec read_diagnosis_spec(const Node& spec);
DiagnosisSpec read_diagnosis_spec(const std::filesystem::path& path);

/// For each file that the spec names and that is not there: where it is named, and what it may be meant to be.
std::vector<SpecError> missing_files(const DiagnosisSpec& spec);

}  // namespace bayesctrl
