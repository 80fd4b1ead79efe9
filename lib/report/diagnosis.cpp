#include "diagnose/verdict/diagnosis.hpp"

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

/// " (or actuator lag)": what the recordings cannot separate from an effect.
std::string or_alike(const Diagnosis& d, const std::string& name) {
  for (const std::vector<std::string>& alike : d.indistinguishable) {  // "coulomb_friction@2"
    if (alike.empty() || !in_words(alike.front()).starts_with(name)) continue;
    std::string others;
    for (std::size_t i = 1; i < alike.size(); ++i) others += (i > 1 ? ", " : "") + in_words(alike[i]);
    if (!others.empty()) return " (or " + others + ")";
  }
  return "";
}

/// "coulomb friction in joint 1 and input gain in joint 2".
std::string effects_in_words(const Diagnosis& d) {
  const std::vector<ExplainedEffect>& effects = d.explanation.effects;
  std::string what;
  for (const ExplainedEffect& effect : effects) {
    const std::string name = in_words(effect.name);
    what += (what.empty() ? "" : &effect == &effects.back() ? " and " : ", ") + name + or_alike(d, name);
    if (d.joints > 1) what += " in joint " + std::to_string(effect.joint);
  }
  return what;
}

/// The verdict as a mechanic would say it.
std::string sentence(const Diagnosis& d) {
  const std::vector<ExplainedEffect>& effects = d.explanation.effects;
  const std::string what = effects_in_words(d), sure = percent_text(d.explanation.probability);
  const CauseShares& shares = d.mismatch.depends_on;
  switch (d.verdict) {
    case Verdict::named: {
      const std::string text = effects.size() == 1 ? effects.front().text : "";
      return "The model lacks " + what + (text.empty() ? "" : ": " + text) + ". Probability " + sure + ".";
    }
    case Verdict::ambiguous:
      return "Something is missing, most probably " + what + " (" + sure + "), but not surely.";
    case Verdict::nothing_missing:
      return d.mismatch.explained_by_parameters
                 ? "No physics is missing: other values of the free parameters explain the recordings."
                 : "Nothing is missing: the model explains the recordings down to the sensor's noise.";
    case Verdict::too_little_data:
      return "The recordings say too little for a diagnosis.";
    case Verdict::check_spec:
      return d.suspicions.empty() ? "The recordings do not fit the spec: check its units, signs and columns first."
                                  : "Check the spec. " + d.suspicions.front().sentence;
    case Verdict::unknown:
      break;
  }
  return "Something is missing that no known effect explains" +
         (shares.largest() > 0.0 ? "; it depends on " + std::string(to_name(shares.leading())) + " most" : "") +
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
  const Diagnosis d = read_diagnosis(folder / "diagnosis.json");
  return page(d.name, assets::k_diagnosis_js,
              {{"sentence", sentence(d)},
               {"diagnosis", to_json(d)},
               {"origin", origin(folder)},
               {"runs", recordings(folder / "fit.csv", {"set", "recording"}, {"measured", "before", "after"})},
               {"torque", recordings(folder / "missing_torque.csv", {"recording"}, {"torque", "sd", "q", "v"})}});
}

}  // namespace bayesctrl
