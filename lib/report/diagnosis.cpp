#include <map>

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/verdict/sentence.hpp"
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

/// A table over time, a group for each text in the columns `by`, the last of which is the recording:
/// [{set, recording, t, joints: [{column: curve}]}]. Empty where there is no file. `newer`: columns that files of
/// earlier versions lack.
ordered_json recordings(const fs::path& path, const std::vector<std::string>& by, std::vector<std::string> columns,
                        const std::vector<std::string>& newer = {}) {
  ordered_json list = ordered_json::array();
  if (!fs::exists(path)) return list;
  const std::string file = path.string();
  const Table table = read_csv(path);
  const int joints = joints_of(table, columns.front());
  if (joints == 0) throw DataError(Location{file}, "has no column '" + columns.front() + "'");
  std::map<std::string, std::vector<double>> values{{"t", numbers(table, "t", file)}};
  for (const std::string& column : newer) {
    if (table.find(numbered(column, 0, joints)) != nullptr) columns.push_back(column);
  }
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
  return page(
      d.name, assets::k_diagnosis_js,
      {{"sentence", sentence(d)},
       {"diagnosis", to_json(d)},
       {"origin", origin(folder)},
       {"runs", recordings(folder / "fit.csv", {"set", "recording"}, {"measured", "before", "after"})},
       {"torque", recordings(folder / "missing_torque.csv", {"recording"}, {"torque", "sd", "q", "v"}, {"u", "law"})}});
}

}  // namespace bayesctrl
