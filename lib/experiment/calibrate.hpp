#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "io/node.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// One setting that a calibration may change: a number searched log-uniformly, or one of several choices.
struct Vary {
  double low = 0.0;
  double high = 0.0;
  std::vector<std::string> choices;

  static void fields(auto& self, auto&& field) {
    field("low", self.low, {kNonNegative, "", "lowest value"});
    field("high", self.high, {kNonNegative, "", "highest value"});
    field("choices", self.choices, {.text = "values to choose from instead, as text"});
  }
  std::string problem() const {
    const bool range = low > 0.0 && high >= low;
    return range != choices.empty() ? "a varied setting needs either low and high, 0 < low <= high, or choices" : "";
  }
};

/// A search for settings that a publication does not report. The score of a candidate is the sum over the published
/// cells of the square of |result - value| / tolerance, that distance being at most kWorstCell; a tolerance of zero
/// counts as one half.
struct Calibration {
  static constexpr std::string_view kName = "calibration";
  std::string study;
  std::vector<std::string> against;
  std::vector<std::string> controllers;
  Named<Vary> vary;
  int digits = 2;
  int starts = 50;
  int draws = 40;
  int steps = 400;
  std::uint64_t seed = 1;

  static void fields(auto& self, auto&& field) {
    field("study", self.study, {.text = "spec of the study, relative to this file", .required = true});
    field("against", self.against, {.text = "published tables, relative to this file", .required = true});
    field("controllers", self.controllers, {.text = "the controllers to run; empty: all"});
    field("vary", self.vary, {.text = "settings by path, as for --set", .required = true});
    field("digits", self.digits, {between(1, 6), "", "significant digits of a searched number"});
    field("starts", self.starts, {between(1, 1e6), "", "independent searches"});
    field("draws", self.draws, {between(1, 1e6), "", "random candidates of a search, of which the best goes on"});
    field("steps", self.steps, {between(0, 1e6), "", "random steps from there, each kept if it is no worse"});
    field("seed", self.seed, {.text = "of the search"});
  }
};

inline constexpr double kWorstCell = 10.0;

struct CalibrationResult {
  std::vector<std::string> assignments;  // "path=value", as for --set
  double score = 0.0;
  int searches = 1;  // that ended here
  Table comparison;  // every published cell of these controllers
};

/// A spec whose study, published tables and controllers go together. Files are relative to the file that it was read
/// from. Throws SpecError or IoError.
Calibration read_calibration(const Node& spec);

/// The best candidate of each search, best first. Searches run on `jobs` threads; the result does not depend on it.
std::vector<CalibrationResult> calibrate(const std::filesystem::path& spec, int jobs,
                                         const std::function<void(std::size_t done, std::size_t total)>& progress = {},
                                         const std::function<bool()>& stop = {});

/// Each candidate once, in the same order, with the number of searches that ended there.
std::vector<CalibrationResult> distinct(std::vector<CalibrationResult> results);

}  // namespace bayesctrl
