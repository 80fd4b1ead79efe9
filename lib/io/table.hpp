#pragma once

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace bayesctrl {

/// A missing value, a number or a text.
using Cell = std::variant<std::monostate, double, std::int64_t, std::string>;

/// A number, or a missing value.
inline Cell optional_number(const std::optional<double>& value) { return value ? Cell(*value) : Cell(); }

struct Column {
  std::string name;
  std::string unit = "";                                       // SI, "" means dimensionless or unknown
  std::variant<std::vector<double>, std::vector<Cell>> cells;  // numbers alone are kept as such: trajectories are long

  std::size_t size() const;
  Cell at(std::size_t row) const;
  bool operator==(const Column&) const = default;
};

/// Whether all cells are missing or empty texts.
bool is_empty(const Column& column);

/// Named columns of equal length.
struct Table {
  std::vector<Column> columns;

  /// Length of the columns. Throws std::invalid_argument if they differ.
  std::size_t rows() const;
  const Column* find(std::string_view name) const;
  bool operator==(const Table&) const = default;
};

/// A table of one row: name and cell of each column.
Table one_row(std::vector<std::pair<std::string, Cell>> cells);

/// Adds the rows of `more` below. Columns are matched by name; where one table lacks a column its cells are missing.
/// Throws std::invalid_argument if a column's two units are given and differ.
void append(Table& table, const Table& more);

/// Header and rows as in RFC 4180 with "\n" ends; missing cells are empty, numbers have `digits` significant digits, or
/// if 0 the shortest text that reads back the same. Texts that could be taken for a number or a missing cell are
/// quoted.
std::string to_csv(const Table& table, int digits = 0);

/// A Markdown table for people; units stand in the header, numbers to the right.
std::string to_markdown(const Table& table, int digits);

/// Aligned columns for a terminal; units stand below the names, numbers to the right.
std::string to_text(const Table& table, int digits);

/// A list of one object per row; a missing cell is null, infinities as in io/emit.hpp.
nlohmann::ordered_json to_json(const Table& table);

/// The inverse of `to_csv` up to units: a column of whole numbers, of texts, or with missing cells has cells, any other
/// column of numbers has doubles. Throws IoError, or DataError "file:line: ..." for rows that differ in length,
/// repeated or empty column names and misplaced quotes. `file` names the source in messages.
Table parse_csv(std::string_view text, const std::string& file);
Table read_csv(const std::filesystem::path& path);

/// The column's numbers, missing cells as NaN. Throws DataError, located at `file`, if there is no such column or if it
/// holds a text.
std::vector<double> numbers(const Table& table, std::string_view column, const std::string& file);

}  // namespace bayesctrl
