#pragma once

#include "trial/cases.hpp"

namespace bayesctrl::trial {

/// Recordings that no machine has made: positions that move smoothly, beside inputs that have nothing to do with them.
/// Whatever is named there is wrong.
Case nonsense_case(const TrialSpec& spec, const Order& order);

}  // namespace bayesctrl::trial
