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
std::vector<Study> read_studies(const std::filesystem::path& spec, const Overrides& overrides = {});

}  // namespace bayesctrl
