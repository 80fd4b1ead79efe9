#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "report/report.hpp"

namespace bayesctrl {

/// The page of each kind of result folder, for `report`. All throw IoError, DataError, or nlohmann::json::exception
/// where a JSON file lacks what the page shows.
std::string experiment_page(const std::vector<std::filesystem::path>& folders, const Published* published);
std::string diagnosis_page(const std::filesystem::path& folder);
std::string trial_page(const std::filesystem::path& folder);

}  // namespace bayesctrl
