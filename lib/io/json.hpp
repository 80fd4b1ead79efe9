#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>

namespace bayesctrl {

/// A JSON file of a result folder. Throws IoError, or DataError where it is damaged.
nlohmann::ordered_json read_json(const std::filesystem::path& file);

}  // namespace bayesctrl
