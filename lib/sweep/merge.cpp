#include "sweep/merge.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/error.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/provenance.hpp"
#include "sweep/bundle.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr const char* kMissing = "missing";

/// The row of a run whose results are not there.
Table missing_row(const SweepPlan& plan, int run) {
  std::vector<std::pair<std::string, Cell>> cells{{"run", std::int64_t{run} + 1}, {"experiment", plan.manifest.name}};
  for (auto& setting : plan.point(run)) cells.emplace_back(std::move(setting));
  cells.emplace_back("status", std::string(kMissing));
  cells.emplace_back("reason", std::string("not run"));
  return one_row(std::move(cells));
}

std::string without_header(const std::string& csv) { return csv.substr(csv.find('\n') + 1); }

double quantile(const std::vector<double>& sorted, double p) {
  const double place = p * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

/// Numbers of a column at some rows, without what is missing; nothing if the column holds a text there.
std::optional<std::vector<double>> numbers_at(const Column& column, const std::vector<std::size_t>& rows) {
  std::vector<double> values;
  for (const std::size_t row : rows) {
    const Cell cell = column.at(row);
    if (std::holds_alternative<std::string>(cell)) return std::nullopt;
    const auto* number = std::get_if<double>(&cell);
    const auto* whole = std::get_if<std::int64_t>(&cell);
    const double value = number ? *number : whole ? static_cast<double>(*whole) : std::nan("");
    if (!std::isnan(value)) values.push_back(value);
  }
  return values;
}

struct Group {
  std::string name;
  std::vector<std::size_t> rows;  // with status "ok"
  std::int64_t planned = 0, done = 0, failed = 0;
};

std::vector<Group> groups_of(const Table& table) {
  std::vector<Group> groups;
  const Column *controller = table.find("controller"), *status = table.find("status");
  std::int64_t missing = 0;
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const Cell state = status->at(row);
    if (state == Cell(std::string(kMissing))) {
      ++missing;
      continue;
    }
    const Cell cell = controller ? controller->at(row) : Cell();
    const auto* text = std::get_if<std::string>(&cell);
    const std::string name = text ? *text : "";
    auto group = std::find_if(groups.begin(), groups.end(), [&](const Group& g) { return g.name == name; });
    if (group == groups.end()) group = groups.insert(groups.end(), Group{name, {}, 0, 0, 0});
    ++group->done;
    if (state == Cell(std::string("ok")))
      group->rows.push_back(row);
    else
      ++group->failed;
  }
  for (Group& group : groups) group.planned = group.done + missing;
  return groups;
}

}  // namespace

Table statistics_of(const Table& table, const std::vector<std::string>& settings) {
  Table result;
  constexpr std::array kTexts{"controller", "column"};
  constexpr std::array kCounts{"n_planned", "n_done", "n_failed", "n"};
  constexpr std::array kFigures{"mean", "sd", "min", "q05", "median", "q95", "max"};
  for (const char* name : kTexts) result.columns.push_back({name, "", std::vector<Cell>{}});
  for (const char* name : kCounts) result.columns.push_back({name, "", std::vector<Cell>{}});
  for (const char* name : kFigures) result.columns.push_back({name, "", std::vector<Cell>{}});
  const auto push = [&](std::size_t& c, Cell cell) {
    std::get<std::vector<Cell>>(result.columns[c++].cells).push_back(std::move(cell));
  };
  const auto is_figure = [&](const Column& column) {
    return column.name != "run" && std::find(settings.begin(), settings.end(), column.name) == settings.end();
  };
  for (const Group& group : groups_of(table)) {
    for (const Column& column : table.columns) {
      std::optional<std::vector<double>> values;
      if (is_figure(column)) values = numbers_at(column, group.rows);
      if (!values || values->empty()) continue;
      std::sort(values->begin(), values->end());
      const auto n = static_cast<double>(values->size());
      const double mean = std::accumulate(values->begin(), values->end(), 0.0) / n;
      double squares = 0.0;
      for (const double value : *values) squares += (value - mean) * (value - mean);
      std::size_t c = 0;
      push(c, group.name.empty() ? Cell() : Cell(group.name));
      push(c, column.name);
      for (const std::int64_t count : {group.planned, group.done, group.failed}) push(c, count);
      push(c, static_cast<std::int64_t>(values->size()));
      push(c, mean);
      push(c, n > 1.0 ? Cell(std::sqrt(squares / (n - 1.0))) : Cell());
      for (const double p : {0.0, 0.05, 0.5, 0.95, 1.0}) push(c, quantile(*values, p));
    }
  }
  return result;
}

Merged merge_sweep(const SweepPlan& plan, const fs::path& folder, bool partial) {
  Merged merged;
  merged.planned = static_cast<std::size_t>(plan.manifest.runs);
  std::vector<std::optional<std::string>> bundles;
  std::string damage;
  const std::string* any = nullptr;
  for (int b = 0; b < plan.bundles(); ++b) {
    BundleText bundle = read_bundle(plan, folder, b);
    if (bundle.csv) merged.done += plan.runs_in(b);
    if (damage.empty() && !bundle.damage.empty()) {
      damage = "; " + bundle_file(plan, folder, b).string() + " " + bundle.damage;
    }
    bundles.push_back(std::move(bundle.csv));
  }
  for (const auto& csv : bundles) {
    if (csv && any == nullptr) any = &*csv;
  }
  const std::string count = std::to_string(merged.done) + " of " + std::to_string(merged.planned) + " runs are done";
  if (any == nullptr || (merged.done < merged.planned && !partial)) {
    const std::string where = folder.string();
    throw DataError({where}, count + damage + ": run bayesctrl sweep resume " + where +
                                 (any == nullptr ? "" : ", or merge what is there with --partial"));
  }
  const std::string header = any->substr(0, any->find('\n') + 1);
  const Table columns = parse_csv(header, "table.csv");
  std::string csv = header;
  for (int b = 0; b < plan.bundles(); ++b) {
    if (const auto& own = bundles[static_cast<std::size_t>(b)]) {
      csv += without_header(*own);
      continue;
    }
    Table missing = columns;
    for (int run = plan.first_of(b); run < plan.end_of(b); ++run) append(missing, missing_row(plan, run));
    csv += without_header(to_csv(missing));
  }
  merged.statistics = statistics_of(parse_csv(csv, "table.csv"), plan.sweep.paths());

  ordered_json summary{{"name", plan.manifest.name}, {"kind", plan.manifest.kind}, {"hash", plan.manifest.hash}};
  summary["revision"] = plan.manifest.revision;
  summary["n_done"] = merged.done;
  summary["n_planned"] = merged.planned;
  summary["statistics"] = to_json(merged.statistics);
  const ordered_json origin = provenance(fs::path(plan.manifest.spec).filename().string(),
                                         {{"text", plan.manifest.text}, {"assignments", plan.manifest.assignments}});
  FileBatch batch;
  batch.add(folder / "table.csv", csv);
  batch.add(folder / "statistics.csv", to_csv(merged.statistics));
  batch.add(folder / "summary.json", summary.dump(2) + "\n");
  batch.add(folder / "provenance.json", origin.dump(2) + "\n");
  batch.commit();
  return merged;
}

}  // namespace bayesctrl
