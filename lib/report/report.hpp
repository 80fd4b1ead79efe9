#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "io/table.hpp"

namespace bayesctrl {

/// Published numbers beside the results of experiments: the table that `check` compares, one row per cell.
struct Published {
  std::string name;    // "Table 2"
  std::string source;  // where the numbers were published
  Table cells;
};

/// One self-contained HTML page: for folders of experiments (`run`; of a sweep, the folder above its points), or for
/// the one folder of a diagnosis or of a trial. It asks nothing of any network. `published`, if any, is shown for
/// experiments alone. Throws IoError where a folder holds no results, DataError for damaged files.
std::string report(const std::vector<std::filesystem::path>& folders, const Published* published = nullptr);

/// Writes report.html for each diagnosis and trial into its folder, and one for all experiments together: into the
/// folder if it is one, else into the nearest folder above all. With `out`, one page for all folders there. Returns the
/// files.
std::vector<std::filesystem::path> write_reports(const std::vector<std::filesystem::path>& folders,
                                                 const Published* published = nullptr,
                                                 const std::filesystem::path& out = "");

}  // namespace bayesctrl
