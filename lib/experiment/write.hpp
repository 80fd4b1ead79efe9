#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "experiment/run.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// Folder of a study's results: the slug of its name and, for a sweep, a number per point below it.
std::filesystem::path result_folder(const std::filesystem::path& out, const Study& study, std::size_t point);

/// Writes one study's results into `folder`: summary.json, table.csv, provenance.json and, per controller that ran, a
/// folder with trajectory.csv, data.csv and posterior.csv. All files appear together or not at all. Wall time stands in
/// provenance.json alone. Throws IoError.
void write_results(const StudyOutcome& outcome, const std::filesystem::path& folder, const std::string& spec_name);

/// The table.csv of `folder` if it holds this study with all its settings, run to its end by this revision of the
/// program. Throws DataError for files that are not whole.
std::optional<Table> finished_results(const Study& study, const std::filesystem::path& folder);

/// The table.csv of each folder (or file), one below the other. Throws IoError or DataError.
Table gather_tables(const std::vector<std::filesystem::path>& folders);

}  // namespace bayesctrl
