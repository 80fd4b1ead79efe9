#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace bayesctrl {

/// Named columns of numbers and, of a CSV, the line of the file at which each row stands.
struct DataTable {
  std::vector<std::string> names;
  std::vector<std::vector<double>> columns;
  std::vector<int> lines;
  std::vector<std::size_t> rows{};  // of the file, from 0; empty: all
  std::size_t left_out = 0;         // rows of the file between those, too many to be kept

  /// The column of that name, or else of that number, from 1.
  std::optional<std::size_t> find(const std::string& column) const;
};

/// What of a table is kept. A cell is read as a number only where its row and its column are.
struct Wanted {
  std::vector<std::string> columns{};  // by name or number; none: all. The others stay empty
  /// Whether a row counts, by its number and by the number in the first of these columns; none: every one does.
  std::function<bool(std::size_t row, double first)> counts{};
  /// Numbers that are kept, at least; of longer tables pieces of rows, evenly spread.
  std::size_t numbers = std::numeric_limits<std::size_t>::max();
  std::size_t pieces = 32;
};

/// CSV as measuring programs write it: separated by commas, semicolons or tabs, with a byte-order mark, names in UTF-8
/// or Latin-1 with blanks around them, a trailing separator, comment lines (#), decimal commas where semicolons
/// separate. Where the first row holds numbers there is no header, and columns are named "1", "2", ... Cells that are
/// no number are NaN. Throws DataError for rows of another length and no rows.
DataTable parse_data_csv(std::string_view text, const std::string& file, const Wanted& wanted = {});

/// A CSV of any length, in memory that the numbers that are kept need, or by its ending a MATLAB file, whole. Throws
/// DataError, IoError.
DataTable read_data_table(const std::filesystem::path& path, const Wanted& wanted = {});

/// Vectors of a MATLAB file (versions 4, 5 and 7.3); a field of a struct is named "struct.field". Throws DataError.
DataTable read_mat(const std::filesystem::path& path);

}  // namespace bayesctrl
