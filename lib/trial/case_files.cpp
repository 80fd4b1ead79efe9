#include "trial/case_files.hpp"

#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/table.hpp"
#include "physics/parameters.hpp"
#include "spec/model.hpp"

namespace bayesctrl::trial {

using nlohmann::ordered_json;

std::string recording_name(int number) {
  return number < kRecordings ? "train" + std::to_string(number + 1) + ".csv" : "test1.csv";
}

std::string to_file(const Recorded& recorded) {
  const int n = static_cast<int>(recorded.position.cols());
  std::vector<std::vector<double>> columns(static_cast<std::size_t>(1 + 2 * n));
  for (std::size_t k = 0; k < recorded.time.size(); ++k) {
    if (k >= recorded.lost_from && k < recorded.lost_to) continue;
    const auto row = static_cast<Eigen::Index>(k);
    columns[0].push_back(recorded.time[k]);
    for (int j = 0; j < n; ++j) {
      columns[static_cast<std::size_t>(1 + j)].push_back(recorded.position(row, j));
      columns[static_cast<std::size_t>(1 + n + j)].push_back(recorded.input(row, j));
    }
  }
  Table table;
  table.columns.push_back({"t", "", columns[0]});
  for (int j = 0; j < n; ++j)
    table.columns.push_back({numbered("q", j, n), "", columns[static_cast<std::size_t>(1 + j)]});
  for (int j = 0; j < n; ++j)
    table.columns.push_back({numbered("u", j, n), "", columns[static_cast<std::size_t>(1 + n + j)]});
  if (recorded.temperature) {
    std::vector<double> celsius;
    for (const double t : columns[0]) celsius.push_back(recorded.temperature->at(0, t));
    table.columns.push_back({"temperature", "", celsius});
  }
  return to_csv(table, 12);
}

ordered_json spec_json(const std::string& name, const Plant& nominal, const std::vector<std::string>& free) {
  const int n = joints(nominal);
  ordered_json q = ordered_json::array(), u = ordered_json::array(), train = ordered_json::array();
  for (int j = 0; j < n; ++j) {
    q.push_back(numbered("q", j, n));
    u.push_back(numbered("u", j, n));
  }
  for (int r = 0; r < kRecordings; ++r) train.push_back(recording_name(r));
  ordered_json model = json_value(Model{nominal});
  if (!free.empty()) model["free"] = free;
  return {{"name", name},
          {"model", model},
          {"signals", {{"time", "t"}, {"position", q}, {"input", u}}},
          {"recordings", train},
          {"held_out", {recording_name(kRecordings)}}};
}

ordered_json effect_truth(const Effect& effect, double size) {
  ordered_json values = ordered_json::object();
  for (const auto& [name, value, info] : parameters(effect.form)) values[std::string(name)] = value;
  ordered_json object{
      {"name", name_of(effect.form)}, {"joint", effect.joint + 1}, {"size", size}, {"parameters", values}};
  if (effect.recording >= 0) object["recording"] = recording_name(effect.recording);
  if (effect.form.roles().of_one_recording) object["recording_number"] = effect.recording + 1;
  return object;
}

}  // namespace bayesctrl::trial
