#pragma once

#include "diagnose/recording/measured.hpp"

namespace bayesctrl {

/// RMS error with which windows of `horizon` seconds are predicted without any physics: what of each joint's positions
/// an autoregression says that is fitted to those of `train`, or that they stay at their mean, whichever is better in a
/// window. NaN without windows.
double autoregression_error(const std::vector<Measured>& train, const std::vector<Measured>& data, double horizon);

}  // namespace bayesctrl
