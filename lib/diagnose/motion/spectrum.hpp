#pragma once

#include <vector>

#include "diagnose/motion/smoother.hpp"
#include "diagnose/recording/measured.hpp"

namespace bayesctrl {

/// Frequencies (rad/s, increasing) at which the missing torque of one joint is strongest: at most `count` of the
/// multiples 2 `step`, 3 `step`, ... below `highest`, the largest local maxima of its power |sum_k d(t_k) exp(-i w
/// t_k)|^2 over the samples of all recordings, the time of each counted from its start (Lomb 1976, without the weights
/// of few samples).
std::vector<double> strongest_frequencies(const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
                                          int joint, double step, double highest, std::size_t count);

}  // namespace bayesctrl
