#include <map>

#include "base/error.hpp"
#include "base/format.hpp"
#include "report/page.hpp"
#include "report/pages.hpp"
#include "report/read.hpp"
#include "report_assets.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

/// What the page reads beside the data of its plots: a file that lacks any of it was not written by this version.
void require_of_diagnosis(const ordered_json& d) {
  for (const char* path :
       {"/reason", "/fit/unit", "/fit/horizon_s", "/fit/noise_floor", "/fit/train/before", "/fit/held_out/before",
        "/mismatch/detected", "/mismatch/depends_on", "/mismatch/time", "/explanation/probability",
        "/explanation/equation", "/alternatives", "/indistinguishable", "/parameters", "/residual"}) {
    d.at(ordered_json::json_pointer(path));
  }
}

/// Rows that have the same text in `by`, in the order of their first.
std::vector<std::pair<std::string, std::vector<std::size_t>>> groups(const Table& table,
                                                                     const std::vector<std::string>& by,
                                                                     const std::string& file) {
  std::vector<std::vector<std::string>> columns;
  for (const std::string& column : by) columns.push_back(texts(table, column, file));
  std::vector<std::pair<std::string, std::vector<std::size_t>>> list;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    std::string name;
    for (const auto& column : columns) name += (name.empty() ? "" : "\n") + column[row];
    if (list.empty() || list.back().first != name) list.push_back({name, {}});
    list.back().second.push_back(row);
  }
  return list;
}

/// "coulomb friction" of "coulomb_friction", also where a joint follows.
std::string in_words(std::string name) {
  name = name.substr(0, name.find('@'));
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// The verdict as a mechanic would say it.
std::string sentence(const ordered_json& d) {
  const std::string verdict = d.at("verdict");
  const ordered_json& effects = d.at("explanation").at("effects");
  std::string what;
  for (const ordered_json& effect : effects) {
    std::string name = in_words(effect.at("name"));
    for (const ordered_json& alike : d.at("indistinguishable")) {  // "coulomb_friction@2"
      if (in_words(alike.at(0)).starts_with(name)) {
        std::string others;
        for (std::size_t i = 1; i < alike.size(); ++i) others += (i > 1 ? ", " : "") + in_words(alike.at(i));
        if (!others.empty()) name += " (or " + others + ")";
      }
    }
    what += (what.empty() ? "" : &effect == &effects.back() ? " and " : ", ") + name;
    if (d.at("parameters").contains("mass1")) what += " in joint " + std::to_string(effect.at("joint").get<int>());
  }
  std::string text = effects.size() == 1 ? effects.at(0).at("text").get<std::string>() : "";
  const std::string sure = percent_text(d.at("explanation").at("probability").get<double>());
  if (verdict == "named") {
    return "The model lacks " + what + (text.empty() ? "" : ": " + text) + ". Probability " + sure + ".";
  }
  if (verdict == "ambiguous") return "Something is missing, most probably " + what + " (" + sure + "), but not surely.";
  if (verdict == "nothing_missing") {
    return d.at("mismatch").at("explained_by_parameters").get<bool>()
               ? "No physics is missing: other values of the free parameters explain the recordings."
               : "Nothing is missing: the model explains the recordings down to the sensor's noise.";
  }
  if (verdict == "too_little_data") return "The recordings say too little for a diagnosis.";
  std::string leading;
  double most = 0.0;
  for (const auto& [name, share] : d.at("mismatch").at("depends_on").items()) {
    if (share.get<double>() > most) {
      most = share.get<double>();
      leading = name;
    }
  }
  return std::string("Something is missing that no known effect explains") +
         (leading.empty() ? "" : "; it depends on " + leading + " most") +
         (what.empty() ? "." : ". Beside it the model lacks " + what + ".");
}

/// A table over time, a group for each text in the columns `by`, the last of which is the recording:
/// [{set, recording, t, joints: [{column: curve}]}]. Empty where there is no file.
ordered_json recordings(const fs::path& path, const std::vector<std::string>& by,
                        const std::vector<std::string>& columns) {
  ordered_json list = ordered_json::array();
  if (!fs::exists(path)) return list;
  const std::string file = path.string();
  const Table table = read_csv(path);
  const int joints = joints_of(table, columns.front());
  if (joints == 0) throw DataError(Location{file}, "has no column '" + columns.front() + "'");
  std::map<std::string, std::vector<double>> values{{"t", numbers(table, "t", file)}};
  for (const std::string& column : columns) {
    for (int j = 0; j < joints; ++j) {
      const std::string name = numbered(column, j, joints);
      values[name] = numbers(table, name, file);
    }
  }
  for (const auto& [name, all] : groups(table, by, file)) {
    const std::vector<std::size_t> rows = thinned(all);
    ordered_json group{{"recording", name.substr(name.find('\n') + 1)}, {"t", curve(values.at("t"), rows)}};
    if (by.size() > 1) group["set"] = name.substr(0, name.find('\n'));
    for (int j = 0; j < joints; ++j) {
      ordered_json joint;
      for (const std::string& column : columns) joint[column] = curve(values.at(numbered(column, j, joints)), rows);
      group["joints"].push_back(std::move(joint));
    }
    list.push_back(std::move(group));
  }
  return list;
}

}  // namespace

std::string diagnosis_page(const fs::path& folder) {
  const ordered_json d = read_json(folder / "diagnosis.json");
  require_of_diagnosis(d);
  return page(d.at("name").get<std::string>(), assets::k_diagnosis_js,
              {{"sentence", sentence(d)},
               {"diagnosis", d},
               {"origin", origin(folder)},
               {"runs", recordings(folder / "fit.csv", {"set", "recording"}, {"measured", "before", "after"})},
               {"torque", recordings(folder / "missing_torque.csv", {"recording"}, {"torque", "sd", "q", "v"})}});
}

}  // namespace bayesctrl
