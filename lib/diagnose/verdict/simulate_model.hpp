#pragma once

#include "diagnose/recording/spec.hpp"
#include "io/table.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

/// A model.yaml of `diagnose`.
struct ModelFile {
  std::string name;
  Model model;
  Signals signals;
  double horizon = 1.0;  // s

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "of the diagnosis that wrote it"});
    field("model", self.model,
          {.text = "plant, parameters, effects and the remainder, if there is one", .required = true});
    field("signals", self.signals, {.text = "which columns mean what", .required = true});
    field("horizon_s", self.horizon, {kPositive, "s", "of each free run"});
  }
};

/// Whether a spec is a model.yaml rather than a study.
bool is_model_file(const std::filesystem::path& path);
ModelFile read_model_file(const Node& file);

/// Free runs of the model over windows of a recording, beside what was measured: t, q, v, u (numbered for several
/// joints), measured. `rms`: measured less simulated.
struct SimulatedModel {
  Table table;
  double rms = 0.0;
};
SimulatedModel simulate_model(const ModelFile& file, const std::filesystem::path& input, double horizon);

}  // namespace bayesctrl
