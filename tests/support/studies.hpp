#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "experiment/run.hpp"
#include "io/node.hpp"
#include "io/table.hpp"

namespace bayesctrl::testing {

/// A file of configs/.
std::filesystem::path config(const std::string& name);

/// The spec of a small study that runs in a millisecond: a slide of 2 kg from rest to 1 m in 2 s, with the controllers
/// P1, oracle, SP1 and SP2 (trained from SP1), each changed by assignments "path=value".
Node slide_spec(const std::vector<std::string>& changes = {});
Study slide(const std::vector<std::string>& changes = {});
std::string slide_text();

/// Changes to the slide under which SP1's samples repeat without noise: thresholds that are never met, and samples that
/// a kernel as wide as this cannot tell apart.
std::vector<std::string> repeating();

/// Changes to the slide under which SP1 cannot begin to control it: what it believes of b cannot be inverted.
std::vector<std::string> uninvertible();

/// Changes under which the slide diverges under sample and hold (w2 Delta_u > 2), but not under the continuous P1.
std::vector<std::string> unstable();

StudyOutcome run_one(const Study& study, int jobs = 1);

/// One study of configs/ after its run.
StudyOutcome run_config(const std::string& name);

/// A number of `summary_table`, NaN where it is missing.
double metric(const StudyOutcome& outcome, const std::string& controller, const std::string& name);

/// Every regular file below a folder: its path relative to it, and its bytes.
std::map<std::string, std::string> files_below(const std::filesystem::path& folder);

std::vector<std::string> column_names(const Table& table);

/// A column as texts, each cell as in a CSV file.
std::vector<std::string> column_texts(const Table& table, const std::string& name);

}  // namespace bayesctrl::testing
