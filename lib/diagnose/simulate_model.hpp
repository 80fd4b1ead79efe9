#pragma once

#include "diagnose/spec.hpp"
#include "io/table.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// A model.yaml of `diagnose`.
struct ModelFile {
  Model model;
  Signals signals;
  double horizon = 1.0;  // s
};

/// Whether a spec is a model.yaml rather than a study.
bool is_model_file(const std::filesystem::path& path);
ModelFile read_model_file(const std::filesystem::path& path);

/// Free runs of the model over windows of a recording, beside what was measured: t, q, v, u (numbered for several
/// joints), measured. `rms`: measured less simulated.
struct SimulatedModel {
  Table table;
  double rms = 0.0;
};
SimulatedModel simulate_model(const ModelFile& file, const std::filesystem::path& input, double horizon);

}  // namespace bayesctrl
