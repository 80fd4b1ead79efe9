#pragma once

#include <nlohmann/json.hpp>

#include "io/node.hpp"

namespace bayesctrl {

/// Terms of remainders were once written {kind, joint, a, b, c, d, weight}. The letters are the parameters of the type
/// of that name in the order of their declaration (late_push and late_drag leave b out); letters that are missing were
/// 0, 1, 0, 1, those beyond the parameters meant nothing; what is true or false was a number that is not 0 or 0, and
/// the side of a threshold 1 or -1.
bool is_older_term(const Node& term);

/// The same in the notation of today, each value at its place in the file.
Node renewed_term(const Node& term);

nlohmann::ordered_json older_term_schema();

}  // namespace bayesctrl
