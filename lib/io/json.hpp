#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "base/error.hpp"

namespace bayesctrl {

/// A JSON file of a result folder. Throws IoError, or DataError where it is damaged.
nlohmann::ordered_json read_json(const std::filesystem::path& file);

/// What `read` makes of results in `place`; DataError names it where they are not of the form that `read` expects.
auto read_results_in(const std::filesystem::path& place, auto&& read) {
  try {
    return read();
  } catch (const nlohmann::json::exception& error) {
    throw DataError({place.string()}, std::string("results are damaged or of another version: ") + error.what());
  }
}

}  // namespace bayesctrl
