#include "inspect/difference.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

#include "base/error.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "io/emit.hpp"
#include "io/json.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;
using Values = ResultValues::Values;

/// Appends every leaf under a dotted name. Lists of plain values are one leaf; members of other lists go by their
/// `name`, or else by their number from 1.
void flatten(const std::string& name, const ordered_json& value, Values& values) {
  const auto below = [&](const std::string& key) { return name.empty() ? key : name + "." + key; };
  const auto structured = [](const ordered_json& item) { return item.is_structured(); };
  if (value.is_object()) {
    for (const auto& [key, item] : value.items()) flatten(below(key), item, values);
  } else if (value.is_array() && std::any_of(value.begin(), value.end(), structured)) {
    for (std::size_t i = 0; i < value.size(); ++i) {
      const bool named = value[i].is_object() && value[i].contains("name") && value[i]["name"].is_string();
      flatten(below(named ? value[i]["name"].get<std::string>() : std::to_string(i + 1)), value[i], values);
    }
  } else {
    values.emplace_back(name, value);
  }
}

/// What depends on the machine's load, or says in words what numbers say too.
bool is_left_out(std::string_view name) {
  constexpr std::string_view kNames[] = {
      "seconds", "text", "equation", "truth sha256", "processor seconds, mean", "processor seconds, most"};
  const std::string_view last = name.substr(name.rfind('.') + 1);
  return std::any_of(std::begin(kNames), std::end(kNames), [&](std::string_view n) { return n == name || n == last; });
}

/// The rows of an experiment by controller and, in a sweep, by the point's settings.
Values row_values(const ordered_json& rows) {
  Values values;
  for (const ordered_json& row : rows) {
    std::string name = row.value("controller", "");
    for (const auto& [key, value] : row.items()) {
      const bool point =
          value.is_string() && key != "experiment" && key != "controller" && key != "status" && key != "reason";
      if (point) name += " " + key + "=" + value.get<std::string>();
    }
    for (const auto& [key, value] : row.items()) {
      const bool metric = value.is_number() || key == "status" || (key == "reason" && value != "");
      if (metric) values.emplace_back(name + "." + key, value);
    }
  }
  return values;
}

void read_settings(const fs::path& folder, ResultValues& results) {
  if (!fs::exists(folder / "provenance.json")) return;
  const ordered_json provenance = read_json(folder / "provenance.json");
  if (provenance.contains("spec")) flatten("", provenance["spec"], results.settings);
}

const ordered_json* find(const Values& values, const std::string& name) {
  const auto found = std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == name; });
  return found == values.end() ? nullptr : &found->second;
}

Cell cell(const ordered_json* value) {
  if (value == nullptr || value->is_null()) return {};
  if (value->is_number_integer()) return value->get<std::int64_t>();
  if (value->is_number()) return value->get<double>();
  return value->is_string() ? value->get<std::string>() : to_yaml_line(*value);
}

Cell change_percent(const ordered_json* first, const ordered_json* other) {
  if (first == nullptr || other == nullptr || !first->is_number() || !other->is_number()) return {};
  const double a = first->get<double>(), b = other->get<double>();
  return a == b ? Cell(0.0) : a == 0.0 ? Cell{} : Cell(100.0 * (b - a) / std::abs(a));
}

/// Names of `part` in all results, in order of appearance.
std::vector<std::string> all_names(const std::vector<ResultValues>& results, Values ResultValues::*part) {
  std::vector<std::string> names;
  for (const ResultValues& result : results) {
    for (const auto& [name, value] : result.*part) {
      if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

Table differing(const std::vector<ResultValues>& results, Values ResultValues::*part, const std::string& title,
                bool changes) {
  Table table;
  table.columns.push_back({title, "", std::vector<Cell>{}});
  for (const ResultValues& result : results) table.columns.push_back({result.label, "", std::vector<Cell>{}});
  for (std::size_t i = 1; changes && i < results.size(); ++i) {
    const std::string suffix = results.size() > 2 ? " of " + results[i].label : "";
    table.columns.push_back({"change" + suffix, "%", std::vector<Cell>{}});
  }
  const auto push = [&](std::size_t column, Cell value) {
    std::get<std::vector<Cell>>(table.columns[column].cells).push_back(std::move(value));
  };
  for (const std::string& name : all_names(results, part)) {
    std::vector<const ordered_json*> values;
    for (const ResultValues& result : results) values.push_back(find(result.*part, name));
    const auto same = [&](const ordered_json* v) {
      return (v == nullptr) == (values[0] == nullptr) && (v == nullptr || *v == *values[0]);
    };
    if (std::all_of(values.begin(), values.end(), same)) continue;
    push(0, name);
    for (std::size_t i = 0; i < values.size(); ++i) push(1 + i, cell(values[i]));
    for (std::size_t i = 1; changes && i < values.size(); ++i) {
      push(values.size() + i, change_percent(values[0], values[i]));
    }
  }
  return table;
}

ResultValues values_in(const fs::path& folder) {
  ResultValues results{folder.string(), "", {}, {}};
  read_settings(folder, results);
  if (fs::exists(folder / "diagnosis.json")) {
    results.kind = "diagnosis";
    flatten("", to_json(read_diagnosis(folder / "diagnosis.json")), results.metrics);
  } else if (fs::exists(folder / "summary.json")) {
    const ordered_json summary = read_json(folder / "summary.json");
    const bool experiment = summary.contains("controllers");
    results.kind = experiment ? "experiment" : "trial";
    experiment ? void(results.metrics = row_values(summary["controllers"])) : flatten("", summary, results.metrics);
  } else if (fs::exists(folder / "table.csv")) {  // the folder above the points of a sweep
    results.kind = "experiment";
    results.metrics = row_values(to_json(read_csv(folder / "table.csv")));
  } else {
    throw IoError(folder.string() + ": holds no diagnosis.json, summary.json or table.csv");
  }
  std::erase_if(results.metrics, [](const auto& value) { return is_left_out(value.first); });
  return results;
}

}  // namespace

ResultValues read_results(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw IoError(folder.string() + ": no folder of results");
  return read_results_in(folder, [&] { return values_in(folder); });
}

ResultDifference difference(const std::vector<ResultValues>& results) {
  for (const ResultValues& result : results) {
    if (result.kind == results.front().kind) continue;
    throw DataError({result.label}, "holds a result of another kind (" + result.kind + ") than " +
                                        results.front().label + " (" + results.front().kind + ")");
  }
  return {differing(results, &ResultValues::settings, "setting", false),
          differing(results, &ResultValues::metrics, "metric", true)};
}

}  // namespace bayesctrl
