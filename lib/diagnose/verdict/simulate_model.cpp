#include "diagnose/verdict/simulate_model.hpp"

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/fit/free_runs.hpp"
#include "diagnose/recording/read_recording.hpp"
#include "diagnose/settings.hpp"
#include "io/read.hpp"

namespace bayesctrl {

namespace {

std::vector<double> column(const Eigen::MatrixXd& values, Eigen::Index j) {
  return {values.col(j).begin(), values.col(j).end()};
}

}  // namespace

bool is_model_file(const std::filesystem::path& path) {
  const Node root = read_yaml(path);
  return root.find("signals") != nullptr && root.find("model") != nullptr && root.find("recordings") == nullptr;
}

ModelFile read_model_file(const Node& root) {
  auto file = read<ModelFile>(root);
  if (static_cast<int>(file.signals.position.size()) != joints(file.model.plant)) {
    throw SpecError(root.find("signals")->value.where, "signals and plant differ in their number of joints");
  }
  if (file.signals.temperature.empty() && feel_temperature(file.model.effects)) {
    throw SpecError(root.find("signals")->value.where,
                    "an effect of the model depends on a temperature: add that signal");
  }
  return file;
}

SimulatedModel simulate_model(const ModelFile& file, const std::filesystem::path& input, double horizon) {
  RecordingFile recording;
  recording.file = input;
  recording.name = input.filename().string();
  const std::vector<Measured> data{read_recording(recording, file.signals)};
  if (const std::string why = no_window(data, horizon); !why.empty()) {
    throw DataError({input.string()}, "the horizon is " + why);
  }
  const Eigen::VectorXd noise = noise_level(data).cwiseMax(1e-12);
  const std::vector<Trajectory> paths{
      smooth(file.model.plant, data[0], noise, likely_torque_prior(file.model.plant, data, noise))};
  const FreeRuns runs = free_runs({file.model.plant, file.model.effects, file.model.remainder}, data, paths, horizon,
                                  true, kSettings.verdict.simulation_step);
  SimulatedModel result;
  result.rms = runs.rms;
  const int n = joints(file.model.plant);
  std::vector<double> time;
  for (const double t : data[0].time) time.push_back(data[0].start + t);
  result.table.columns.push_back({"t", "s", time});
  for (int j = 0; j < n; ++j)
    result.table.columns.push_back(
        {numbered("q", j, n), unit_for(file.model.plant, "rad or m"), column(runs.simulated[0], j)});
  for (int j = 0; j < n; ++j)
    result.table.columns.push_back(
        {numbered("v", j, n), unit_for(file.model.plant, "rad/s or m/s"), column(runs.velocity[0], j)});
  for (int j = 0; j < n; ++j)
    result.table.columns.push_back(
        {numbered("u", j, n), unit_for(file.model.plant, "unit of u"), column(data[0].input, j)});
  for (int j = 0; j < n; ++j)
    result.table.columns.push_back(
        {numbered("measured", j, n), unit_for(file.model.plant, "rad or m"), column(data[0].position, j)});
  return result;
}

}  // namespace bayesctrl
