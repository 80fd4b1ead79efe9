#pragma once

#include "trial/cases.hpp"

namespace bayesctrl::trial {

/// One joint without an input, let go once and recorded for 10 s at 51 Hz; noise 0, 1 or 5 % of the motion, up to
/// three hidden effects, each of which moves free runs of 1 s by 5 to 50 % of the motion. Another start is held out.
Case short_case(const TrialSpec& spec, const Order& order);

}  // namespace bayesctrl::trial
