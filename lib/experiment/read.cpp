#include "experiment/read.hpp"

#include <algorithm>

#include "io/emit.hpp"
#include "io/read.hpp"
#include "io/schema.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kMostPoints = 100'000;  // of one sweep

/// A text in quotes where YAML needs them.
std::string in_quotes(const std::string& text) { return to_yaml_line(nlohmann::ordered_json(text)); }

/// The YAML text of one value of a sweep, in one line, for `set_path` and for the tables.
std::string to_line(const Node& node) {
  std::string text;
  switch (node.kind) {
    case Node::Kind::null:
      return "null";
    case Node::Kind::scalar:
      return node.quoted || node.text.find_first_of(",[]{}\n") != std::string::npos ? in_quotes(node.text) : node.text;
    case Node::Kind::sequence:
      for (const Node& item : node.items) text += (text.empty() ? "" : ", ") + to_line(item);
      return "[" + text + "]";
    case Node::Kind::map:
      for (const Node::Entry& entry : node.entries) {
        text += (text.empty() ? "" : ", ") + in_quotes(entry.key) + ": " + to_line(entry.value);
      }
      return "{" + text + "}";
  }
  return text;
}

struct Axis {
  std::string path;
  Location where;
  std::vector<std::string> values;
};

/// Takes `sweep` out of the spec.
std::vector<Axis> take_sweep(Node& root) {
  std::vector<Axis> axes;
  const auto sweep = std::find_if(root.entries.begin(), root.entries.end(),
                                  [](const Node::Entry& entry) { return entry.key == "sweep"; });
  if (sweep == root.entries.end()) return axes;
  detail::require_map(sweep->value, "sweep");
  std::size_t points = 1;
  for (const Node::Entry& entry : sweep->value.entries) {
    detail::require_list(entry.value, entry.key);
    if (entry.value.items.empty()) throw SpecError(entry.where, "sweep over '" + entry.key + "' has no values");
    Axis axis{entry.key, entry.where, {}};
    for (const Node& value : entry.value.items) axis.values.push_back(to_line(value));
    points *= axis.values.size();
    if (points > kMostPoints) {
      throw SpecError(entry.where, "the sweep has more than " + std::to_string(kMostPoints) + " points");
    }
    axes.push_back(std::move(axis));
  }
  root.entries.erase(sweep);
  return axes;
}

/// The study of one point: the spec with the `index[a]`-th value of each axis a.
Study read_point(Node spec, const std::vector<Axis>& axes, const std::vector<std::size_t>& index) {
  try {
    for (std::size_t a = 0; a < axes.size(); ++a) set_path(spec, axes[a].path + "=" + axes[a].values[index[a]]);
    Study study = read<Study>(spec);
    for (std::size_t a = 0; a < axes.size(); ++a) study.point.emplace_back(axes[a].path, axes[a].values[index[a]]);
    return study;
  } catch (const SpecError& error) {  // of a value of the sweep: say where in the file the sweep is
    for (const Axis& axis : axes) {
      if (std::string_view(error.what()).starts_with("--set " + axis.path + "="))
        throw SpecError(axis.where, error.what());
    }
    throw;
  }
}

}  // namespace

std::vector<Study> read_studies(const Node& spec) {
  Node root = spec;
  const std::vector<Axis> axes = take_sweep(root);

  std::vector<Study> studies;
  std::vector<std::size_t> index(axes.size(), 0);
  while (true) {
    studies.push_back(read_point(root, axes, index));

    std::size_t a = axes.size();
    while (a > 0 && ++index[a - 1] == axes[a - 1].values.size()) index[--a] = 0;
    if (a == 0) break;
  }
  return studies;
}

std::vector<Study> read_studies(const std::filesystem::path& spec, const Overrides& overrides) {
  Node root = read_yaml(spec);
  for (const std::string& assignment : overrides.assignments) set_path(root, assignment);
  std::vector<Study> studies = read_studies(root);
  for (Study& study : studies) study.seed = overrides.seed.value_or(study.seed);
  return studies;
}

std::string study_yaml(const Node& spec) {
  std::string text = to_yaml(to_json(read_studies(spec).front()));  // the first point: the sweep sets it again
  Node root = spec;
  const std::vector<Axis> axes = take_sweep(root);
  if (!axes.empty()) text += "sweep:\n";
  for (const Axis& axis : axes) {
    text += "  " + in_quotes(axis.path) + ": [";
    for (const std::string& value : axis.values) text += (text.back() == '[' ? "" : ", ") + value;
    text += "]\n";
  }
  return text;
}

nlohmann::ordered_json study_schema() {
  nlohmann::ordered_json result = schema<Study>();
  result["properties"]["sweep"] = {{"type", "object"},
                                   {"additionalProperties", {{"type", "array"}, {"minItems", 1}}},
                                   {"description", "values of settings by path: every combination is run"}};
  return result;
}

}  // namespace bayesctrl
