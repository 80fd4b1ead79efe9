#include "diagnose/spec.hpp"

#include <algorithm>

#include "diagnose/fit.hpp"
#include "io/read.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

Signal read_signal(const Node& node, std::string_view name, bool input) {
  Signal signal;
  signal.where = node.where;
  if (node.kind == Node::Kind::scalar) {
    signal.column = detail::to_text(node, name);
    return signal;
  }
  detail::require_map(node, name);
  detail::Names known{"column", "scale", "offset", "unit"};
  if (input) known.push_back("hold");
  detail::require_known_keys(node, name, known);
  const Node::Entry* column = node.find("column");
  if (column == nullptr) detail::refuse_missing(node, name, "column", {.text = "the column's name in the file"});
  signal.column = detail::to_text(column->value, "column");
  if (const Node::Entry* scale = node.find("scale")) signal.scale = detail::to_double(scale->value, "scale", {});
  if (const Node::Entry* offset = node.find("offset")) signal.offset = detail::to_double(offset->value, "offset", {});
  if (const Node::Entry* unit = node.find("unit")) signal.unit = detail::to_text(unit->value, "unit");
  if (const Node::Entry* hold = node.find("hold")) {
    signal.linear_hold = detail::to_word(hold->value, "hold", {"zero_order", "linear"}) == 1;
  }
  if (signal.scale == 0.0) throw SpecError(node.where, "scale = 0 leaves nothing of the signal");
  return signal;
}

std::vector<Signal> read_list(const Node& node, std::string_view name, bool input) {
  if (node.kind != Node::Kind::sequence) return {read_signal(node, name, input)};
  std::vector<Signal> list;
  for (const Node& item : node.items) list.push_back(read_signal(item, name, input));
  return list;
}

std::vector<RecordingFile> read_files(const Node& node, std::string_view name, const fs::path& folder) {
  std::vector<RecordingFile> list;
  const auto add = [&](const Node& item) {
    RecordingFile file;
    file.where = item.where;
    if (item.kind == Node::Kind::scalar) {
      file.name = detail::to_text(item, name);
    } else {
      detail::require_map(item, name);
      detail::require_known_keys(item, name, {"file", "from", "to", "simulation"});
      const Node::Entry* path = item.find("file");
      if (path == nullptr) detail::refuse_missing(item, name, "file", {.text = "a CSV or MAT file"});
      file.name = detail::to_text(path->value, "file");
      if (const Node::Entry* from = item.find("from")) file.from = detail::to_double(from->value, "from", {kAny, "s"});
      if (const Node::Entry* to = item.find("to")) file.to = detail::to_double(to->value, "to", {kAny, "s"});
      if (file.from && file.to && *file.from >= *file.to) throw SpecError(item.where, "from must be before to");
      if (const Node::Entry* simulation = item.find("simulation")) {
        file.simulation = folder / detail::to_text(simulation->value, "simulation");
      }
    }
    file.file = folder / file.name;
    list.push_back(std::move(file));
  };
  if (node.kind == Node::Kind::sequence) {
    for (const Node& item : node.items) add(item);
  } else {
    add(node);
  }
  return list;
}

bool overlap(const RecordingFile& a, const RecordingFile& b) {
  std::error_code error;
  const bool same = fs::equivalent(a.file, b.file, error) || a.file.lexically_normal() == b.file.lexically_normal();
  return same && a.from.value_or(-kInfinity) <= b.to.value_or(kInfinity) &&
         b.from.value_or(-kInfinity) <= a.to.value_or(kInfinity);
}

std::vector<std::size_t> read_effects(const Node* node) {
  const std::vector<std::string_view> names = names_of(static_cast<const EffectForm*>(nullptr));
  std::vector<std::size_t> list;
  if (node == nullptr) {
    for (std::size_t i = 0; i < names.size(); ++i) list.push_back(i);
    return list;
  }
  detail::require_list(*node, "effects");
  for (const Node& item : node->items) {
    const std::size_t kind = detail::to_word(item, "effects", names);
    if (std::find(list.begin(), list.end(), kind) == list.end()) list.push_back(kind);
  }
  return list;
}

}  // namespace

Signals read_signals(const Node& node) {
  detail::require_map(node, "signals");
  detail::require_known_keys(node, "signals", {"time", "position", "velocity", "input"});
  Signals signals;
  const Node::Entry* time = node.find("time");
  const Node::Entry* position = node.find("position");
  const Node::Entry* input = node.find("input");
  if (time == nullptr)
    detail::refuse_missing(node, "signals", "time", {.text = "a column, or {rate: samples per second}"});
  if (position == nullptr) detail::refuse_missing(node, "signals", "position", {.text = "a column, or one per joint"});
  if (input == nullptr) detail::refuse_missing(node, "signals", "input", {.text = "a column, or one per joint"});
  if (time->value.kind == Node::Kind::map && time->value.find("rate") != nullptr) {
    detail::require_known_keys(time->value, "time", {"rate"});
    signals.rate = detail::to_double(time->value.find("rate")->value, "rate", {kPositive, "Hz"});
  } else {
    signals.time = read_signal(time->value, "time", false);
  }
  signals.position = read_list(position->value, "position", false);
  signals.input = read_list(input->value, "input", true);
  if (const Node::Entry* velocity = node.find("velocity"))
    signals.velocity = read_list(velocity->value, "velocity", false);
  const std::size_t joints = signals.position.size();
  if (joints == 0) throw SpecError(position->value.where, "position needs at least one column");
  if (joints > static_cast<std::size_t>(kMaxJoints)) {
    throw SpecError(position->value.where, "at most " + std::to_string(kMaxJoints) + " joints");
  }
  if (signals.input.size() != joints) {
    throw SpecError(input->value.where, "input has " + std::to_string(signals.input.size()) +
                                            " columns, position has " + std::to_string(joints) +
                                            ": one input per joint");
  }
  if (!signals.velocity.empty() && signals.velocity.size() != joints) {
    throw SpecError(node.find("velocity")->value.where,
                    "velocity needs one column per joint, " + std::to_string(joints));
  }
  return signals;
}

DiagnosisSpec read_diagnosis_spec(const fs::path& path) {
  const Node root = read_yaml(path);
  detail::require_map(root, "the spec");
  detail::require_known_keys(root, "the spec",
                             {"name", "model", "signals", "recordings", "held_out", "effects", "horizon_s"});
  for (const char* needed : {"name", "signals", "recordings"}) {
    if (root.find(needed) == nullptr) detail::refuse_missing(root, "the spec", needed, {});
  }
  const fs::path folder = path.parent_path();
  DiagnosisSpec spec;
  spec.name = detail::to_text(root.find("name")->value, "name");
  spec.signals = read_signals(root.find("signals")->value);
  const Node& recordings = root.find("recordings")->value;
  spec.recordings = read_files(recordings, "recordings", folder);
  if (spec.recordings.empty()) throw SpecError(recordings.where, "recordings is empty");
  if (const Node::Entry* held_out = root.find("held_out")) {
    spec.held_out = read_files(held_out->value, "held_out", folder);
  }
  for (const RecordingFile& test : spec.held_out) {
    for (const RecordingFile& train : spec.recordings) {
      if (overlap(test, train)) {
        throw SpecError(test.where,
                        "held_out '" + test.name + "' is also a training recording: it would prove nothing");
      }
    }
  }
  if (const Node::Entry* horizon = root.find("horizon_s")) {
    spec.horizon = detail::to_double(horizon->value, "horizon_s", {kPositive, "s"});
  }
  const Node::Entry* effects = root.find("effects");
  spec.effects = read_effects(effects == nullptr ? nullptr : &effects->value);

  if (const Node::Entry* entry = root.find("model")) {
    Node model = entry->value;
    detail::require_map(model, "model");
    Node free;
    std::erase_if(model.entries, [&](const Node::Entry& e) {
      if (e.key != "free") return false;
      free = e.value;
      return true;
    });
    spec.plant = read<Model>(model).plant;
    if (joints(*spec.plant) != spec.joints()) {
      throw SpecError(entry->value.where, "the plant has " + std::to_string(joints(*spec.plant)) +
                                              " joints, signals.position has " + std::to_string(spec.joints()));
    }
    if (free.kind != Node::Kind::null) {
      detail::require_list(free, "free");
      const std::vector<std::string> names = parameter_names(*spec.plant);
      const detail::Names allowed(names.begin(), names.end());
      for (const Node& item : free.items) {
        const std::string& name = names[detail::to_word(item, "free", allowed)];
        if (std::find(spec.free.begin(), spec.free.end(), name) != spec.free.end()) {
          throw SpecError(item.where, "free names '" + name + "' twice");
        }
        spec.free.push_back(name);
      }
    }
  } else if (std::any_of(spec.recordings.begin(), spec.recordings.end(),
                         [](const RecordingFile& file) { return file.simulation.empty(); })) {
    detail::refuse_missing(root, "the spec", "model", {.text = "or a simulation beside every recording"});
  }
  return spec;
}

}  // namespace bayesctrl
