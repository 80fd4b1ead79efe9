#pragma once

#include <string>
#include <vector>

#include "io/table.hpp"

namespace bayesctrl {

/// How a plot is drawn: `width` counts all its characters in a line, `rows` those of the curve alone.
struct PlotStyle {
  int width = 80;
  int rows = 5;
  bool colour = false;
};

/// A curve over time (s) in braille dots (two by four in a character) under a title, with its range at the left and
/// that of time below. Points that are not finite are left out; where time goes back another curve begins. Each line
/// ends with "\n". Throws std::invalid_argument if time and y differ in length.
std::string plot(const std::string& title, const std::vector<double>& time, const std::vector<double>& y,
                 const PlotStyle& style);

/// Plots of these columns over the column t, two beside each other. Throws DataError if there is no such column.
std::string plot_columns(const Table& table, const std::vector<std::string>& columns, const PlotStyle& style);

/// Characters that a terminal shows: of UTF-8 text without escape sequences.
std::size_t shown_length(std::string_view text);

}  // namespace bayesctrl
