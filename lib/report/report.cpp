#include "report/report.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/files.hpp"
#include "io/table.hpp"
#include "report/page.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr std::size_t kMostBytes = std::size_t{1} << 30;
constexpr std::size_t kMostPoints = 3000;  // of one curve; longer ones are thinned out
constexpr int kBins = 10;                  // of stated probabilities

ordered_json read_json(const fs::path& file) {
  try {
    return ordered_json::parse(read_file(file, kMostBytes));
  } catch (const nlohmann::json::exception& error) {
    throw DataError(Location{file.string()}, error.what());
  }
}

double rounded(double x) { return std::isfinite(x) && x != 0.0 ? std::stod(format(x, 6)) : x; }

/// Numbers of some rows; what is missing is null.
ordered_json curve(const std::vector<double>& values, const std::vector<std::size_t>& rows) {
  ordered_json list = ordered_json::array();
  for (const std::size_t row : rows) {
    if (std::isfinite(values[row])) {
      list.push_back(rounded(values[row]));
    } else {
      list.push_back(nullptr);
    }
  }
  return list;
}

/// Rows that have the same text in `by`, thinned out, in the order of their first.
std::vector<std::pair<std::string, std::vector<std::size_t>>> groups(const Table& table,
                                                                     const std::vector<std::string>& by) {
  std::vector<std::pair<std::string, std::vector<std::size_t>>> list;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::string name;
    for (const std::string& column : by) {
      const Cell cell = table.find(column)->at(row);
      name +=
          (name.empty() ? "" : "\n") + (std::holds_alternative<std::string>(cell) ? std::get<std::string>(cell) : "");
    }
    if (list.empty() || list.back().first != name) list.push_back({name, {}});
    list.back().second.push_back(row);
  }
  for (auto& [name, rows] : list) {
    const std::size_t every = 1 + rows.size() / kMostPoints;
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < rows.size(); i += every) kept.push_back(rows[i]);
    rows = std::move(kept);
  }
  return list;
}

/// "torque" of a machine with one joint, "torque1", "torque2", ... of one with several.
int joints_of(const Table& table, const std::string& column) {
  if (table.find(column) != nullptr) return 1;
  int joints = 0;
  while (table.find(column + std::to_string(joints + 1)) != nullptr) ++joints;
  return joints;
}

/// "coulomb friction" of "coulomb_friction", also where a joint follows.
std::string in_words(std::string name) {
  name = name.substr(0, name.find('@'));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// The verdict as a mechanic would say it.
std::string sentence(const ordered_json& d) {
  const std::string verdict = d["verdict"];
  const ordered_json& effects = d["explanation"]["effects"];
  std::string what;
  for (const ordered_json& effect : effects) {
    std::string name = in_words(effect["name"]);
    for (const ordered_json& alike : d["indistinguishable"]) {  // "coulomb_friction@2"
      if (in_words(alike[0]).starts_with(name)) {
        for (std::size_t i = 1; i < alike.size(); ++i) name += " or " + in_words(alike[i]);
      }
    }
    what += (what.empty() ? "" : &effect == &effects.back() ? " and " : ", ") + name;
    if (d["parameters"].contains("mass1")) what += " in joint " + std::to_string(effect["joint"].get<int>());
  }
  std::string text = effects.size() == 1 ? effects[0]["text"].get<std::string>() : "";
  const std::string sure = format(100.0 * d["explanation"]["probability"].get<double>(), 3) + " %";
  if (verdict == "named") {
    return "The model lacks " + what + (text.empty() ? "" : ": " + text) + ". Probability " + sure + ".";
  }
  if (verdict == "ambiguous") return "Something is missing, most probably " + what + " (" + sure + "), but not surely.";
  if (verdict == "nothing_missing") {
    return d["mismatch"]["explained_by_parameters"].get<bool>()
               ? "No physics is missing: other values of the free parameters explain the recordings."
               : "Nothing is missing: the model explains the recordings down to the sensor's noise.";
  }
  if (verdict == "too_little_data") return "The recordings say too little for a diagnosis.";
  std::string leading;
  double most = 0.0;
  for (const auto& [name, share] : d["mismatch"]["depends_on"].items()) {
    if (share.get<double>() > most) {
      most = share.get<double>();
      leading = name;
    }
  }
  return std::string("Something is missing that no known effect explains") +
         (leading.empty() ? "" : "; it depends on " + leading + " most") +
         (what.empty() ? "." : ". Beside it the model lacks " + what + ".");
}

std::string diagnosis_page(const fs::path& folder) {
  const ordered_json d = read_json(folder / "diagnosis.json");
  ordered_json data{{"kind", "diagnosis"}, {"sentence", sentence(d)},       {"diagnosis", d},
                    {"joints", 1},         {"runs", ordered_json::array()}, {"torque", ordered_json::array()}};
  const auto add = [&](const fs::path& file, const char* list, const std::vector<std::string>& by,
                       const std::vector<std::pair<std::string, std::string>>& columns) {
    if (!fs::exists(file)) return;
    const Table table = read_csv(file);
    const int joints = joints_of(table, columns.front().first);
    data["joints"] = joints;
    const std::vector<double> t = numbers(table, "t", file.string());
    std::map<std::string, std::vector<double>> values;
    for (const auto& [column, key] : columns) {
      for (int j = 0; j < joints; ++j) {
        const std::string name = numbered(column, j, joints);
        if (table.find(name) != nullptr) values[name] = numbers(table, name, file.string());
      }
    }
    for (const auto& [name, rows] : groups(table, by)) {
      ordered_json group{{"recording", name.substr(name.find('\n') + 1)}};
      if (by.size() > 1) group["set"] = name.substr(0, name.find('\n'));
      group["t"] = curve(t, rows);
      for (int j = 0; j < joints; ++j) {
        ordered_json joint;
        for (const auto& [column, key] : columns) {
          const auto found = values.find(numbered(column, j, joints));
          if (found != values.end()) joint[key] = curve(found->second, rows);
        }
        group["joints"].push_back(std::move(joint));
      }
      data[list].push_back(std::move(group));
    }
  };
  add(folder / "fit.csv", "runs", {"set", "recording"},
      {{"measured", "measured"}, {"before", "before"}, {"after", "after"}});
  add(folder / "missing_torque.csv", "torque", {"recording"},
      {{"torque", "torque"}, {"sd", "sd"}, {"q", "q"}, {"v", "v"}});
  return page(d["name"].get<std::string>(), data);
}

std::string trial_page(const fs::path& folder) {
  const ordered_json summary = read_json(folder / "summary.json");
  const Table cases = read_csv(folder / "cases.csv");
  const std::string file = (folder / "cases.csv").string();
  const std::vector<double> named = numbers(cases, "named", file), probability = numbers(cases, "probability", file);
  struct Row {
    int cases = 0, said = 0, declined = 0;
  };
  std::map<std::string, Row> rows;
  std::array<std::array<double, 3>, kBins> bins{};  // cases, stated, right
  for (std::size_t i = 0; i < cases.rows(); ++i) {
    const auto text = [&](const char* column) { return std::get<std::string>(cases.find(column)->at(i)); };
    const std::string family = text("family"), verdict = text("verdict");
    if (family == "pysindy") continue;
    const bool nothing = family == "nothing";
    const bool right = nothing ? verdict == "nothing_missing" : named[i] > 0.5;
    Row& row = rows[(family == "outside" ? "outside: " : "") + text("truth")];
    ++row.cases;
    row.said += right;
    row.declined += verdict == "unknown";
    if (verdict != "named" && verdict != "ambiguous") continue;
    auto& bin = bins[static_cast<std::size_t>(std::clamp(static_cast<int>(probability[i] * kBins), 0, kBins - 1))];
    bin[0] += 1.0;
    bin[1] += probability[i];
    bin[2] += right;
  }
  ordered_json confusion = ordered_json::array(), calibration = ordered_json::array();
  for (const auto& [name, row] : rows) {
    confusion.push_back({name, row.cases, row.said, row.cases - row.said - row.declined, row.declined});
  }
  for (const auto& bin : bins) {
    if (bin[0] > 0.0)
      calibration.push_back({{"stated", bin[1] / bin[0]}, {"right", bin[2] / bin[0]}, {"cases", bin[0]}});
  }
  const std::string seed = summary.contains("seed") ? summary["seed"].dump() : "?";
  return page(
      "Trial on concealed effects, seed " + seed,
      {{"kind", "trial"},
       {"sentence", std::to_string(cases.rows()) + " machines with concealed physics, or none, were diagnosed from "
                                                   "their recordings alone; then the truth was opened."},
       {"summary", summary},
       {"confusion", confusion},
       {"calibration", calibration}});
}

}  // namespace

std::string report(const fs::path& folder) {
  if (fs::exists(folder / "diagnosis.json")) return diagnosis_page(folder);
  if (fs::exists(folder / "summary.json") && fs::exists(folder / "cases.csv")) return trial_page(folder);
  throw IoError(folder.string() + " holds neither diagnosis.json nor summary.json with cases.csv");
}

void write_report(const fs::path& folder) { write_file(folder / "report.html", report(folder)); }

}  // namespace bayesctrl
