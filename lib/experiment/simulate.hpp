#pragma once

#include <filesystem>

#include "experiment/read.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// Free run of the study's machine from its initial state: t, q, v, u (numbered for several joints). `input` is a CSV
/// with columns t and u (u1, ...), or empty for u = 0 over the study's duration at its control period. Throws DataError
/// for a table that does not fit, NumericalError where the machine diverges.
Table simulate(const Study& study, const std::filesystem::path& input);

}  // namespace bayesctrl
