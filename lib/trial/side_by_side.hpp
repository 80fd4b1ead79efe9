#pragma once

#include "trial/cases.hpp"

namespace bayesctrl::trial {

/// The side-by-side case of docs/diagnosis.md: q'' = -9.81 sin q - 0.3 q' + 4 u + hidden.
Case pysindy_case(const TrialSpec& spec, const Order& order);

}  // namespace bayesctrl::trial
