#pragma once

#include <optional>
#include <vector>

#include "diagnose/fit/fit.hpp"

namespace bayesctrl {

/// A term of the plant that effects beside it undo along the recorded motion.
struct Cancelled {
  int joint = 0;
  bool of_speed = false;  // what the velocity adds to its accelerations; else what they are at rest
};

/// Whether all effects of a fit together, or one of them alone, undo such a term.
std::optional<Cancelled> cancelled(const Fit& fit, const std::vector<Measured>& data);

}  // namespace bayesctrl
