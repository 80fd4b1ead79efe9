#pragma once

#include "diagnose/recording/measured.hpp"
#include "diagnose/recording/spec.hpp"

namespace bayesctrl {

/// Named columns of numbers and the line of the file at which each row stands.
struct DataTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::vector<int> lines;
};

/// CSV as measuring programs write it: separated by commas, semicolons or tabs, with a byte-order mark, names in UTF-8
/// or Latin-1 with blanks around them, a trailing separator, comment lines (#), decimal commas where semicolons
/// separate. Where the first row holds numbers there is no header, and columns are named "1", "2", ... Cells that are
/// no number are NaN. Throws DataError for rows of another length and no rows.
DataTable parse_data_csv(std::string_view text, const std::string& file);

/// A CSV, or by its ending a MATLAB file. Throws DataError, IoError.
DataTable read_data_table(const std::filesystem::path& path);

/// Vectors of a MATLAB file (versions 4, 5 and 7.3); a field of a struct is named "struct.field". Throws DataError.
DataTable read_mat(const std::filesystem::path& path);

/// A recording in SI units, time from 0 at its first sample. Rows whose time stamp repeats the one before are dropped.
/// Throws DataError: a column that is missing, cells that are no number, time that runs backwards, too few samples.
Measured read_recording(const RecordingFile& file, const Signals& signals);

/// Positions of the user's own simulation at the recording's times (interpolated), samples x joints.
Eigen::MatrixXd read_simulation(const RecordingFile& file, const Signals& signals, const Measured& measured);

}  // namespace bayesctrl
