#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <vector>

#include "io/node.hpp"
#include "io/table.hpp"
#include "spec/sweep.hpp"

namespace bayesctrl {

/// A kind of spec that a sweep can repeat.
struct SweepKind {
  std::string_view name;                                           // as in inspect/kinds.hpp
  std::string_view command;                                        // that runs one of them by itself
  nlohmann::ordered_json (*resolved)(const Node& spec);            // with every default
  std::vector<std::filesystem::path> (*inputs)(const Node& spec);  // files whose content the results depend on
  Table (*run)(const Node& spec, const SweepPoint& point, const std::filesystem::path& keep);  // see below
  bool long_runs;  // of seconds, which a signal ends at once
};

/// `run`: the rows of one run, whose columns depend on the point's paths alone; a run that fails is a row with its
/// reason. `keep`: folder of all that the run's own command would write; empty: nothing is written.
///
/// Throws SpecError for a kind that sweeps do not know.
const SweepKind& sweep_kind(std::string_view name);

}  // namespace bayesctrl
