#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/fields.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// One published number and how close a result must come to it. Exactly one tolerance is given.
struct PublishedCell {
  std::string experiment;
  std::string controller;
  std::string metric;
  double value = 0.0;
  bool rounded = false;
  std::optional<double> relative;
  std::optional<double> absolute;

  static void fields(auto& self, auto&& field) {
    field("experiment", self.experiment, {.text = "the study's name", .required = true});
    field("controller", self.controller, {.text = "the controller's name", .required = true});
    field("metric", self.metric, {.text = "a column of table.csv", .required = true});
    field("value", self.value, {kAny, "", "as published", kRequired});
    field("rounded", self.rounded, {.text = "equal after rounding to a whole number"});
    field("relative", self.relative, {kNonNegative, "", "largest |result / value - 1|"});
    field("absolute", self.absolute, {kNonNegative, "", "largest |result - value|"});
  }
  std::string problem() const;

  /// Whether `result` is within the tolerance; NaN never is.
  bool holds(double result) const;

  /// The tolerance as a distance from `value`: 0.5, relative |value|, or absolute.
  double tolerance() const;

  /// "rounded", "within 10 %", "within 1".
  std::string tolerance_text() const;
};

/// A published table: configs/paper_table2.yaml.
struct PublishedTable {
  static constexpr std::string_view kName = "published_table";
  std::string name;
  std::string source;
  std::vector<PublishedCell> cells;

  static void fields(auto& self, auto&& field) {
    field("name", self.name, {.text = "title of the table", .required = true});
    field("source", self.source, {.text = "where the numbers were published", .required = true});
    field("cells", self.cells, {.text = "the numbers", .required = true});
  }
};

/// The copy that `run` leaves in a result folder, so that pages made later find it.
inline constexpr std::string_view kPublishedFile = "published.yaml";

PublishedTable read_published(const std::filesystem::path& file);

/// Every published cell beside the result: experiment, controller, metric, result, published, deviation_percent,
/// tolerance, ok ("yes", "no", or "missing": no such row, a failed run, or no such metric).
Table compare(const Table& results, const PublishedTable& published);

/// Takes the cells of experiments that have no row in `results` out of `published`. Returns a line for each of these.
std::vector<std::string> take_absent(PublishedTable& published, const Table& results);

/// One line per cell that is not "yes".
std::vector<std::string> violations(const Table& comparison);

}  // namespace bayesctrl
