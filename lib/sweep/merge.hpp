#pragma once

#include <filesystem>
#include <string>

#include "io/table.hpp"
#include "sweep/plan.hpp"

namespace bayesctrl {

/// What `merge` wrote: DIR/table.csv with every run's rows in the order of the plan, DIR/statistics.csv, which says of
/// how many runs each of its figures is taken, and DIR/summary.json.
struct Merged {
  std::size_t done = 0, planned = 0;
  Table statistics;
};

/// Throws DataError where results are missing, unless `partial`: each missing run is then a row with status "missing".
Merged merge_sweep(const SweepPlan& plan, const std::filesystem::path& folder, bool partial);

/// For each controller of a study, or of all runs where the table has none, and each column of numbers: n_planned
/// runs, n_done, n_failed, n (with a number), mean, sd, min, 5 %, median, 95 % and max over runs with status "ok".
Table statistics_of(const Table& table, const std::vector<std::string>& settings);

}  // namespace bayesctrl
