#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "sweep/plan.hpp"

namespace bayesctrl {

/// The rows of some consecutive runs in one file of DIR/results: CSV below a line with the plan's hash and a checksum,
/// so that what was cut short or belongs to another plan is told from what is done.

/// DIR/results/0000001-0000250.csv.
std::filesystem::path bundle_file(const SweepPlan& plan, const std::filesystem::path& folder, int bundle);

/// Writes it whole or not at all. Throws IoError.
void write_bundle(const SweepPlan& plan, const std::filesystem::path& folder, int bundle, std::string_view csv);

/// What became of a bundle.
struct BundleText {
  std::optional<std::string> csv;  // where it is done
  std::string damage;              // where a file is there and is not valid: why
};
BundleText read_bundle(const SweepPlan& plan, const std::filesystem::path& folder, int bundle);

/// Calls line(text) for each record of a CSV text, its end left out; line breaks in quotes are part of a record.
void for_each_record(std::string_view csv, auto&& line) {
  bool quoted = false;
  std::size_t begin = 0;
  for (std::size_t i = 0; i < csv.size(); ++i) {
    if (csv[i] == '"') quoted = !quoted;
    if (csv[i] != '\n' || quoted) continue;
    line(csv.substr(begin, i - begin));
    begin = i + 1;
  }
}

}  // namespace bayesctrl
