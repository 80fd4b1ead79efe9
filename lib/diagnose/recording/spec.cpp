#include "diagnose/recording/spec.hpp"

#include <algorithm>

#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/read.hpp"
#include "physics/parameters.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct SampleRate {
  static constexpr std::string_view kName = "time";
  double rate = 0.0;
  static void fields(auto& self, auto&& field) {
    field("rate", self.rate, {kPositive, "Hz", "samples per second, where no column holds the time", kRequired});
  }
};

void resolve(std::vector<RecordingFile>& files, const fs::path& folder) {
  for (RecordingFile& file : files) {
    file.file = folder / file.name;
    if (!file.simulation_name.empty()) file.simulation = folder / file.simulation_name;
  }
}

/// Whether two recordings are of one file and share more than an instant.
bool overlap(const RecordingFile& a, const RecordingFile& b) {
  std::error_code error;
  const bool same = fs::equivalent(a.file, b.file, error) || a.file.lexically_normal() == b.file.lexically_normal();
  return same && a.from.value_or(-kInfinity) < b.to.value_or(kInfinity) &&
         b.from.value_or(-kInfinity) < a.to.value_or(kInfinity);
}

/// Effects that depend on the temperature are usual where it is recorded, and cannot be looked for where it is not.
void settle_temperature(DiagnosisSpec& spec, const Node& root) {
  const Node::Entry* named = root.find("effects");
  const auto item = [&](std::string_view word) {
    return std::ranges::find(named->value.items, word, [](const Node& node) { return node.text; });
  };
  const bool recorded = !spec.signals.temperature.empty();
  const bool usual = named == nullptr || item("usual") != named->value.items.end();
  for (std::size_t kind = 0; kind < catalogue().size(); ++kind) {
    const EffectLaw& law = *catalogue()[kind];
    if (!law.roles.feels_temperature) continue;
    const bool listed = std::ranges::find(spec.effects, kind) != spec.effects.end();
    if (listed && !recorded)
      throw SpecError(item(law.name)->where, std::string(law.name) + " needs signals.temperature");
    if (!listed && recorded && usual) spec.effects.push_back(kind);
  }
}

/// What `effects` may list: names of the catalogue, and behind them `usual` for those that need not be asked for.
std::vector<std::string_view> words_for_effects() {
  std::vector<std::string_view> words = effect_names();
  words.push_back("usual");
  return words;
}

}  // namespace

EffectNames EffectNames::usual() {
  const std::vector<std::size_t> list = usual_effects();
  return {list.begin(), list.end()};
}

void read_value(const Node& node, Clock& clock) {
  clock = {};
  if (node.find("rate") != nullptr) {
    clock.rate = read<SampleRate>(node).rate;
  } else {
    detail::read_node(node, "time", Info{}, clock.column.emplace());
  }
}

ordered_json json_value(const Clock& clock) {
  return clock.column ? to_json(*clock.column) : to_json(SampleRate{clock.rate});
}

ordered_json schema_value(const Clock*, detail::Definitions& definitions) {
  ordered_json schema = detail::short_schema<Signal>(definitions);
  schema["anyOf"].push_back(detail::object_schema<SampleRate>(definitions));
  return schema;
}

void read_value(const Node& node, Signals& signals) {
  detail::read_fields(node, "signals", signals);
  const auto at = [&](const char* key) { return node.find(key)->value.where; };
  const std::size_t joints = signals.position.size();
  if (joints == 0) throw SpecError(at("position"), "position needs at least one column");
  if (joints > static_cast<std::size_t>(kMaxJoints)) {
    throw SpecError(at("position"), "at most " + std::to_string(kMaxJoints) + " joints");
  }
  if (signals.input.size() != joints) {
    throw SpecError(at("input"), "input has " + std::to_string(signals.input.size()) + " columns, position has " +
                                     std::to_string(joints) + ": one input per joint");
  }
  if (!signals.velocity.empty() && signals.velocity.size() != joints) {
    throw SpecError(at("velocity"), "velocity needs one column per joint, " + std::to_string(joints));
  }
  const auto refuse = [&](const auto& list, const char* key, bool is_temperature) {
    for (const Signal& signal : list) {
      if (signal.unit.empty() || (si_unit(signal.unit) == "degC") == is_temperature) continue;
      throw SpecError(at(key),
                      std::string(key) + " in " + signal.unit + ": " +
                          (is_temperature ? "a temperature is in degC, degF or K" : "that is a temperature's unit"));
    }
  };
  refuse(signals.position, "position", false);
  refuse(signals.velocity, "velocity", false);
  refuse(signals.input, "input", false);
  refuse(signals.temperature, "temperature", true);
  if (signals.temperature.size() > 1 && signals.temperature.size() != joints) {
    throw SpecError(at("temperature"), "temperature needs one column, or one per joint, " + std::to_string(joints));
  }
}

void read_value(const Node& node, EffectNames& effects) {
  detail::require_list(node, "effects");
  effects.clear();
  for (const Node& item : node.items) {
    const std::size_t word = detail::to_word(item, "effects", words_for_effects());
    const EffectNames meant = word < catalogue().size() ? EffectNames{word} : EffectNames::usual();
    for (const std::size_t kind : meant) {
      if (std::find(effects.begin(), effects.end(), kind) == effects.end()) effects.push_back(kind);
    }
  }
}

ordered_json json_value(const EffectNames& effects) {
  ordered_json list = ordered_json::array();
  for (const std::size_t kind : effects) list.push_back(effect_names()[kind]);
  return list;
}

ordered_json schema_value(const EffectNames*, detail::Definitions&) {
  return {{"type", "array"}, {"items", {{"enum", words_for_effects()}}}, {"description", "a list of effects"}};
}

void read_value(const Node& node, NominalModel& nominal) {
  nominal = {};
  if (node.kind == Node::Kind::null) return;
  detail::require_map(node, "model");
  Node model = node, free;
  std::erase_if(model.entries, [&](const Node::Entry& e) {
    if (e.key != "free") return false;
    free = e.value;
    return true;
  });
  const Model given = read<Model>(model);
  if (!given.is_plain()) {
    const Node::Entry* entry = node.find(given.effects.empty() ? "remainder" : "effects");
    throw SpecError(entry != nullptr ? entry->where : node.where,
                    "the model of a diagnosis is a plant alone: effects and remainders are what is looked for");
  }
  nominal.plant = given.plant;
  if (free.kind == Node::Kind::null) return;
  detail::require_list(free, "free");
  const std::vector<std::string> names = parameter_names(*nominal.plant);
  for (const Node& item : free.items) {
    const std::string& name = names[detail::to_word(item, "free", detail::Names(names.begin(), names.end()))];
    if (std::find(nominal.free.begin(), nominal.free.end(), name) != nominal.free.end()) {
      throw SpecError(item.where, "free names '" + name + "' twice");
    }
    nominal.free.push_back(name);
  }
}

ordered_json json_value(const NominalModel& nominal) {
  if (!nominal.plant) return nullptr;
  ordered_json object = json_value(Model{*nominal.plant});
  object["free"] = nominal.free;
  return object;
}

ordered_json schema_value(const NominalModel*, detail::Definitions& definitions) {
  ordered_json schema = model_schema(definitions);
  for (ordered_json& choice : schema["oneOf"]) {
    ordered_json name{{"type", "string"}};
    const ordered_json parameters = choice["properties"].value("parameters", ordered_json::object());
    if (parameters.contains("properties")) {
      ordered_json known = ordered_json::array();
      for (const auto& [key, value] : parameters["properties"].items()) {
        known.push_back(key);
        if (value.value("type", "") != "array") continue;
        for (int i = 0; i < kMaxJoints; ++i) known.push_back(numbered(key, i, kMaxJoints));
      }
      name = {{"enum", known}};
    }
    for (const char* key : {"effects", "remainder"}) choice["properties"].erase(key);
    choice["properties"]["free"] = {{"anyOf", {{{"type", "array"}, {"items", name}}, {{"type", "null"}}}},
                                    {"description", "parameters that may be re-estimated"}};
  }
  schema["oneOf"].push_back({{"type", "null"}});
  return schema;
}

DiagnosisSpec read_diagnosis_spec(const Node& root) {
  auto spec = read<DiagnosisSpec>(root);
  const Node::Entry* horizon = root.find("horizon_s");
  spec.horizon_at = horizon != nullptr ? horizon->value.where : root.where;
  settle_temperature(spec, root);
  const fs::path folder = fs::path(root.where.file).parent_path();
  resolve(spec.recordings, folder);
  resolve(spec.held_out, folder);
  if (spec.recordings.empty()) throw SpecError(root.find("recordings")->value.where, "recordings is empty");
  for (std::size_t i = 0; i < spec.recordings.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      const RecordingFile &again = spec.recordings[i], &first = spec.recordings[k];
      if (!overlap(again, first)) continue;
      throw SpecError(again.where,
                      "'" + again.name + "' is there already: what is counted twice looks twice as certain");
    }
  }
  for (const RecordingFile& test : spec.held_out) {
    for (const RecordingFile& train : spec.recordings) {
      if (overlap(test, train)) {
        throw SpecError(test.where,
                        "held_out '" + test.name + "' is also a training recording: it would prove nothing");
      }
    }
  }
  if (spec.model.plant && joints(*spec.model.plant) != spec.joints()) {
    throw SpecError(root.find("model")->value.where, "the plant has " + std::to_string(joints(*spec.model.plant)) +
                                                         " joints, signals.position has " +
                                                         std::to_string(spec.joints()));
  }
  const auto simulated = [](const RecordingFile& file) { return !file.simulation.empty(); };
  if (!spec.model.plant && !std::all_of(spec.recordings.begin(), spec.recordings.end(), simulated)) {
    detail::refuse_missing(root, "the spec", "model", {.text = "or a simulation beside every recording"});
  }
  return spec;
}

std::vector<SpecError> missing_files(const DiagnosisSpec& spec) {
  std::vector<SpecError> list;
  const auto look_for = [&](const fs::path& file, const Location& where) {
    if (file.empty() || fs::exists(file)) return;
    std::error_code error;
    std::vector<std::string> there;
    for (const auto& entry : fs::directory_iterator(file.parent_path().empty() ? "." : file.parent_path(), error)) {
      there.push_back(entry.path().filename().string());
    }
    const std::string_view meant = nearest(file.filename().string(), {there.begin(), there.end()});
    list.emplace_back(where, "there is no file '" + file.string() + "'" +
                                 (meant.empty() ? "" : ", did you mean '" + std::string(meant) + "'?"));
  };
  for (const std::vector<RecordingFile>* files : {&spec.recordings, &spec.held_out}) {
    for (const RecordingFile& file : *files) {
      look_for(file.file, file.where);
      look_for(file.simulation, file.where);
    }
  }
  return list;
}

DiagnosisSpec read_diagnosis_spec(const fs::path& path) { return read_diagnosis_spec(read_yaml(path)); }

}  // namespace bayesctrl
