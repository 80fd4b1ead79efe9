#pragma once

#include "diagnose/search/explain.hpp"
#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl {

/// The side of the machine on which an effect acts.
Channel channel_of(const EffectForm& form);

/// A time in which measured and simulated motion disagree, in seconds since the recording's start.
struct Interval {
  std::size_t recording = 0;
  double from = 0.0, to = 0.0;
  double score = 0.0;  // RMS of what exceeds the noise, in its standard deviations
};

/// Where the band of the missing torque excludes zero; where none does, windows that the nominal alone does not fit. A
/// step that the best explanation names begins where it says. `smoothed`: states and missing torque of the recordings.
std::vector<Interval> significant_times(const Explanation& explanation, const std::vector<Measured>& data,
                                        const std::vector<Trajectory>& smoothed);

/// Where a recording leaves a simulation (samples x joints) by more than five times the noise, and which joint most.
struct Departure {
  std::vector<Interval> times;
  Eigen::VectorXd distance;  // RMS per joint, in units of the noise
};
Departure departure(const Measured& measured, const Eigen::MatrixXd& simulated, const Eigen::VectorXd& noise,
                    std::size_t recording);

}  // namespace bayesctrl
