#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "experiment/study.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

/// Changes of the command line to every spec.
struct Overrides {
  std::vector<std::string> assignments;  // "path=value"
  std::optional<std::uint64_t> seed;
};

/// The studies of one spec: one, or one per point of its `sweep` (a map from paths to lists of values; every
/// combination is a study, the last path varying fastest). Throws SpecError or IoError.
std::vector<Study> read_studies(const Node& spec);
std::vector<Study> read_studies(const std::filesystem::path& spec, const Overrides& overrides = {});

/// The spec with every default, as YAML that `read_studies` reads back to the same studies.
std::string study_yaml(const Node& spec);

/// JSON Schema of what `read_studies` accepts.
nlohmann::ordered_json study_schema();

}  // namespace bayesctrl
