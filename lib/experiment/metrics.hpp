#pragma once

#include <span>
#include <string_view>

#include "experiment/run.hpp"

namespace bayesctrl {

/// A number that each row of a table shows. A new metric is one line in metrics.cpp.
struct Metric {
  std::string_view name;
  std::string_view unit;
  std::string_view text;
  bool whole = false;                                                     // a count
  double (*value)(const Study& study, const Outcome& outcome) = nullptr;  // NaN where it does not apply
};

std::span<const Metric> all_metrics();

}  // namespace bayesctrl
