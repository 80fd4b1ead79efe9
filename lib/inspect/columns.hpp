#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "diagnose/recording/data_table.hpp"

namespace bayesctrl {

/// What a column of a recording seems to be, from its name: "theta_deg" is a position, pi/180 rad.
struct ColumnGuess {
  std::string column;
  double scale = 1.0;   // to SI units,
  double offset = 0.0;  // added after that
  std::string unit;     // after scaling, empty if the name tells none
  std::string reason;   // why, in a few words
};

struct ColumnGuesses {
  std::optional<ColumnGuess> time;
  std::vector<ColumnGuess> position, velocity, input;  // one per joint; velocity may be empty
  std::vector<ColumnGuess> temperature;                // none, one, or one per joint
};

/// Columns that the user names; the others are guessed.
struct NamedColumns {
  std::string time;
  std::vector<std::string> position, input;
};

/// Names such as t, time; q, theta, angle, x, pos; v, vel, omega; u, tau, torque, force; temp, temperature; with a unit
/// in brackets or after an underscore; numbered for several joints. Where no name is known as an input the first column
/// left over is taken. Throws DataError, located at `file`, if no column can be a position or an input, with the names
/// that there are, or if there is no column of a name that the user gave.
ColumnGuesses guess_columns(const DataTable& table, const std::string& file, const NamedColumns& named = {});

}  // namespace bayesctrl
