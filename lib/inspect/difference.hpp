#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "io/table.hpp"

namespace bayesctrl {

/// A folder of results as plain names and values: "controllers.P1.gain", "P1.energy".
struct ResultValues {
  using Values = std::vector<std::pair<std::string, nlohmann::ordered_json>>;
  std::string label;  // the folder
  std::string kind;   // "experiment", "diagnosis", "trial"
  Values settings;    // of the resolved spec
  Values metrics;     // what came out; wall times are left out
};

/// What run, diagnose or trial wrote into a folder. Throws IoError if it holds no results, DataError for broken ones.
ResultValues read_results(const std::filesystem::path& folder);

/// Rows for what is not the same in all results; names that one of them lacks are missing there.
struct ResultDifference {
  Table settings;  // setting, then a column per result
  Table metrics;   // metric, a column per result, then per further result its change against the first in percent

  bool empty() const { return settings.rows() == 0 && metrics.rows() == 0; }
};

/// Throws DataError if the results are of different kinds.
ResultDifference difference(const std::vector<ResultValues>& results);

}  // namespace bayesctrl
