#pragma once

#include "diagnose/recording/measured.hpp"
#include "diagnose/recording/spec.hpp"

namespace bayesctrl {

/// A recording in SI units, time from 0 at its first sample. Rows whose time stamp repeats the one before are dropped,
/// and a few that stand alone before or behind all others. Of a long file pieces, evenly spread, with gaps between
/// them. Throws DataError: a column that is missing, cells that are no number, time that runs backwards or jumps by a
/// year, too few samples.
Measured read_recording(const RecordingFile& file, const Signals& signals);

/// Positions of the user's own simulation at the recording's times (interpolated), samples x joints.
Eigen::MatrixXd read_simulation(const RecordingFile& file, const Signals& signals, const Measured& measured);

}  // namespace bayesctrl
