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

}  // namespace bayesctrl
