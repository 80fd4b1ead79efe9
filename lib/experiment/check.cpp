#include "experiment/check.hpp"

#include <cmath>
#include <limits>
#include <set>

#include "base/format.hpp"
#include "io/read.hpp"

namespace bayesctrl {

namespace {

std::string text_at(const Table& table, std::string_view column, std::size_t row) {
  const Column* found = table.find(column);
  if (found == nullptr) return "";
  const Cell cell = found->at(row);
  const auto* text = std::get_if<std::string>(&cell);
  return text != nullptr ? *text : "";
}

double number_at(const Table& table, std::string_view column, std::size_t row) {
  const Column* found = table.find(column);
  const Cell cell = found == nullptr ? Cell{} : found->at(row);
  if (const auto* value = std::get_if<double>(&cell)) return *value;
  if (const auto* count = std::get_if<std::int64_t>(&cell)) return static_cast<double>(*count);
  return std::numeric_limits<double>::quiet_NaN();
}

/// Six significant digits: a table that is kept beside the code must not differ in the last bit between machines.
Cell shown(double value) { return std::isnan(value) ? Cell{} : Cell(std::stod(format(value, 6))); }

/// The result for one cell, NaN if there is none from a run that succeeded. Of several rows the last counts.
double result_for(const Table& results, const PublishedCell& cell) {
  double result = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t row = 0; row < results.rows(); ++row) {
    if (text_at(results, "experiment", row) == cell.experiment &&
        text_at(results, "controller", row) == cell.controller) {
      result = text_at(results, "status", row) == "ok" ? number_at(results, cell.metric, row)
                                                       : std::numeric_limits<double>::quiet_NaN();
    }
  }
  return result;
}

}  // namespace

std::string PublishedCell::problem() const {
  const int given = (rounded ? 1 : 0) + (relative ? 1 : 0) + (absolute ? 1 : 0);
  return given == 1 ? "" : "a cell needs exactly one of rounded: true, relative and absolute";
}

bool PublishedCell::holds(double result) const {
  if (rounded) return std::round(result) == value;
  constexpr double kRounding = 1e-12;  // of the comparison itself
  return std::abs(result - value) <= tolerance() * (1.0 + kRounding);
}

double PublishedCell::tolerance() const { return rounded ? 0.5 : relative ? *relative * std::abs(value) : *absolute; }

std::string PublishedCell::tolerance_text() const {
  if (rounded) return "rounded";
  if (relative) return "within " + format(100.0 * *relative, 4) + " %";
  return *absolute == 0.0 ? "exact" : "within " + format(*absolute, 4);
}

PublishedTable read_published(const std::filesystem::path& file) { return read<PublishedTable>(read_yaml(file)); }

Table compare(const Table& results, const PublishedTable& published) {
  std::vector<Cell> experiment, controller, metric, value, expected, deviation, tolerance, ok;
  for (const PublishedCell& cell : published.cells) {
    const double result = result_for(results, cell);
    experiment.emplace_back(cell.experiment);
    controller.emplace_back(cell.controller);
    metric.emplace_back(cell.metric);
    value.push_back(shown(result));
    expected.emplace_back(cell.value);
    deviation.push_back(cell.value == 0.0 ? Cell{} : shown(std::round(1e4 * (result / cell.value - 1.0)) / 100.0));
    tolerance.emplace_back(cell.tolerance_text());
    ok.emplace_back(std::string(std::isnan(result) ? "missing" : cell.holds(result) ? "yes" : "no"));
  }
  return {{{"experiment", "", experiment},
           {"controller", "", controller},
           {"metric", "", metric},
           {"result", "", value},
           {"published", "", expected},
           {"deviation_percent", "", deviation},
           {"tolerance", "", tolerance},
           {"ok", "", ok}}};
}

std::vector<std::string> take_absent(PublishedTable& published, const Table& results) {
  std::set<std::string> present;
  for (std::size_t row = 0; row < results.rows(); ++row) present.insert(text_at(results, "experiment", row));
  std::vector<std::pair<std::string, std::size_t>> absent;
  for (const PublishedCell& cell : published.cells) {
    if (present.contains(cell.experiment)) continue;
    if (absent.empty() || absent.back().first != cell.experiment) absent.emplace_back(cell.experiment, 0);
    ++absent.back().second;
  }
  std::erase_if(published.cells, [&](const PublishedCell& cell) { return !present.contains(cell.experiment); });
  std::vector<std::string> lines;
  for (const auto& [name, count] : absent) {
    lines.push_back(name + " is not among the results: " + std::to_string(count) + " cells not checked");
  }
  return lines;
}

std::vector<std::string> violations(const Table& comparison) {
  std::vector<std::string> lines;
  for (std::size_t row = 0; row < comparison.rows(); ++row) {
    const std::string ok = text_at(comparison, "ok", row);
    if (ok == "yes") continue;
    std::string line = text_at(comparison, "experiment", row) + " " + text_at(comparison, "controller", row) + " " +
                       text_at(comparison, "metric", row) + ": ";
    if (ok == "missing") {
      line += "no result";
    } else {
      line += format(number_at(comparison, "result", row), 6);
    }
    line += ", published " + format(number_at(comparison, "published", row), 6) + " (" +
            text_at(comparison, "tolerance", row) + ")";
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace bayesctrl
