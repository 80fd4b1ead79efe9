#include "support/practice.hpp"

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "io/files.hpp"
#include "io/node.hpp"
#include "io/table.hpp"
#include "physics/catalogue.hpp"

namespace bayesctrl::testing {

namespace {

namespace fs = std::filesystem;

fs::path data_folder() {
  const char* given = std::getenv("BAYESCTRL_DATA");
  return given != nullptr ? fs::path(given) : fs::path(BAYESCTRL_SOURCE_DIR) / ".." / "shared" / "data";
}

const Node& at(const Node& map, std::string_view key) { return map.find(key)->value; }

Plant to_plant(const Node& model) {
  const std::string name = at(model, "plant").text == "custom" ? "pendulum" : at(model, "plant").text;
  Plant plant;
  for_each_alternative(static_cast<const Plant*>(nullptr), [&]<class P>(P form) {
    if constexpr (HasFields<P>) {
      if (P::kName != name) return;
      P::fields(form, [&]<class V>(std::string_view key, V& value, const Info&) {
        if constexpr (std::is_same_v<V, double>) {
          if (const Node::Entry* entry = at(model, "parameters").find(key)) value = std::stod(entry->value.text);
        }
      });
      plant = form;
    }
  });
  return plant;
}

/// "coulomb_friction@2" with its parameters.
Effect to_effect(const std::string& key, const nlohmann::json& parameters) {
  const std::size_t mark = key.find('@');
  std::optional<Effect> effect;
  for_each_effect([&]<class E>(E form) {
    if (E::kName != key.substr(0, mark)) return;
    E::fields(form,
              [&](std::string_view name, double& value, const Info&) { value = parameters.at(std::string(name)); });
    effect = Effect{form, std::stoi(key.substr(mark + 1)) - 1};
  });
  if (!effect) throw std::invalid_argument("no effect " + key);
  return *effect;
}

std::vector<std::string> names(const Node& node) {
  std::vector<std::string> list;
  for (const Node& item : node.items) list.push_back(item.text);
  if (node.kind == Node::Kind::scalar) list.push_back(node.text);
  return list;
}

Eigen::MatrixXd columns(const Table& table, const std::vector<std::string>& names_of_columns) {
  Eigen::MatrixXd result(static_cast<Eigen::Index>(table.rows()), static_cast<Eigen::Index>(names_of_columns.size()));
  for (std::size_t j = 0; j < names_of_columns.size(); ++j) {
    const std::vector<double> values = numbers(table, names_of_columns[j], "");
    result.col(static_cast<Eigen::Index>(j)) =
        Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
  }
  return result;
}

PracticeCase read_case(const fs::path& folder, const nlohmann::json& truth) {
  const Node spec = read_yaml(folder / "spec.yaml");
  PracticeCase result{
      folder.filename().string(), to_plant(at(spec, "model")), truth.at("noise"), truth.at("parameter_error"), {}};
  std::vector<std::string> files = names(at(spec, "recordings"));
  const std::size_t training = files.size();
  for (const std::string& file : names(at(spec, "held_out"))) files.push_back(file);
  const Node& signals = at(spec, "signals");
  for (std::size_t i = 0; i < files.size(); ++i) {
    const Table table = read_csv(folder / files[i]);
    PracticeRecording recording{numbers(table, at(signals, "time").text, files[i]),
                                columns(table, names(at(signals, "position"))),
                                columns(table, names(at(signals, "input"))),
                                {}};
    for (const auto& [key, parameters] : truth.at("effects").items()) {
      // A torque step is in one training recording and in the held-out one.
      const bool elsewhere = truth.at("step_in").is_number() && i < training && truth.at("step_in") != i;
      if (!(elsewhere && key.starts_with("torque_step"))) recording.hidden.push_back(to_effect(key, parameters));
    }
    result.recordings.push_back(std::move(recording));
  }
  return result;
}

}  // namespace

std::vector<PracticeCase> practice_cases() {
  const fs::path folder = data_folder() / "practice";
  std::vector<PracticeCase> cases;
  if (!fs::exists(folder / "truth.json")) return cases;
  const nlohmann::json truth = nlohmann::json::parse(read_file(folder / "truth.json", 10'000'000));
  for (const auto& [name, entry] : truth.items()) cases.push_back(read_case(folder / name, entry));
  return cases;
}

}  // namespace bayesctrl::testing
