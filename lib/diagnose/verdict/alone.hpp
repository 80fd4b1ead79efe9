#pragma once

#include <optional>

#include "diagnose/verdict/judge.hpp"

namespace bayesctrl {

/// Effects of one number any of which alone would do nearly all that is missing (`verdict.alone`), in the linear
/// response along the measured motion; nothing where no two would. `rows`: those of what is missing.
std::optional<Alone> each_alone(const Search& search, const Projected& rows);

}  // namespace bayesctrl
