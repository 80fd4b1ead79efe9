#pragma once

#include <filesystem>
#include <string>

namespace bayesctrl {

/// One self-contained HTML page for a folder of results: of a diagnosis (diagnosis.json) or of a trial (summary.json
/// with cases.csv). It asks nothing of any network. Throws IoError where the folder holds neither, DataError for
/// damaged files.
std::string report(const std::filesystem::path& folder);

/// The same, written to report.html in the folder.
void write_report(const std::filesystem::path& folder);

}  // namespace bayesctrl
