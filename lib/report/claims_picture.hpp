#pragma once

#include <string>

#include "io/table.hpp"

namespace bayesctrl {

/// The claims of a sensitivity (sweep/sensitivity.hpp) as an SVG picture: per claim the share of draws in which it
/// holds with its interval, and how that share varies with the setting over which it varies most. It follows the
/// viewer's dark or light scheme.
std::string claims_picture(const Table& claims, const Table& by_setting);

}  // namespace bayesctrl
