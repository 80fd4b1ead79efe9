#pragma once

namespace bayesctrl {

/// Whether the file descriptor is a terminal that obeys escape sequences.
bool is_terminal(int descriptor);

/// Whether colours may be written to it: a terminal, and NO_COLOR is not set (https://no-color.org).
bool has_colour(int descriptor);

/// Columns of the terminal, or what COLUMNS says, or 80; from 40 to 200.
int terminal_width(int descriptor);

}  // namespace bayesctrl
