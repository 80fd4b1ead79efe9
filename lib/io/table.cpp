#include "io/table.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "base/error.hpp"
#include "base/format.hpp"
#include "io/emit.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

void write_number(double value, int digits, std::string& out) {
  if (std::isnan(value)) {
    out += "nan";  // whatever its sign
    return;
  }
  std::array<char, 400> buffer;
  char* const begin = buffer.data();
  char* const end = begin + buffer.size();
  const auto written = digits > 0 ? std::to_chars(begin, end, value, std::chars_format::general, digits)
                                  : std::to_chars(begin, end, value);
  out.append(begin, written.ptr);
}

/// Quoted if a reader of CSV needs it, or if without quotes it were a number, a missing cell or a file's byte-order
/// mark.
void write_text(std::string_view text, std::string& out) {
  const bool number = is_decimal(text) || text == "nan" || text == "inf" || text == "-inf";
  const bool mark = text.starts_with("\xef\xbb\xbf");
  if (!number && !mark && !text.empty() && text.find_first_of(",\"\r\n") == std::string_view::npos) {
    out += text;
    return;
  }
  out += '"';
  for (const char c : text) out.append(c == '"' ? 2 : 1, c);
  out += '"';
}

void write_cell(const Cell& cell, int digits, std::string& out) {
  if (const auto* number = std::get_if<double>(&cell)) write_number(*number, digits, out);
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) out += std::to_string(*whole);
  if (const auto* text = std::get_if<std::string>(&cell)) write_text(*text, out);
}

void write_markdown_text(std::string_view text, std::string& out) {
  for (const char c : text) {
    if (c == '|' || c == '\\' || c == '`' || c == '*' || c == '_')
      out += {'\\', c};
    else if (c == '<')
      out += "&lt;";
    else if (c == '&')
      out += "&amp;";
    else
      out += c == '\n' || c == '\r' ? ' ' : c;
  }
}

void write_markdown_cell(const Cell& cell, int digits, std::string& out) {
  if (std::holds_alternative<std::monostate>(cell)) return;
  if (const auto* text = std::get_if<std::string>(&cell))
    write_markdown_text(*text, out);
  else
    write_cell(cell, digits, out);
  out += ' ';
}

/// A text in one line, or a number.
void write_plain_cell(const Cell& cell, int digits, std::string& out) {
  const auto* text = std::get_if<std::string>(&cell);
  if (text == nullptr) return write_cell(cell, digits, out);
  for (const char letter : *text) out += static_cast<unsigned char>(letter) < ' ' ? ' ' : letter;
}

bool has_text(const Column& column) {
  const auto* cells = std::get_if<std::vector<Cell>>(&column.cells);
  const auto is_text = [](const Cell& cell) { return std::holds_alternative<std::string>(cell); };
  return cells != nullptr && std::any_of(cells->begin(), cells->end(), is_text);
}

nlohmann::ordered_json cell_to_json(const Cell& cell) {
  if (const auto* number = std::get_if<double>(&cell)) return number_to_json(*number);
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) return *whole;
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  return nullptr;
}

/// The column's cells, ready to take any kind of value.
std::vector<Cell>& general_cells(Column& column) {
  if (const auto* plain = std::get_if<std::vector<double>>(&column.cells)) {
    column.cells = std::vector<Cell>(plain->begin(), plain->end());
  }
  return std::get<std::vector<Cell>>(column.cells);
}

void append_cells(Column& column, const Column& more) {
  auto* plain = std::get_if<std::vector<double>>(&column.cells);
  const auto* plain_more = std::get_if<std::vector<double>>(&more.cells);
  if (plain != nullptr && plain_more != nullptr) {
    plain->insert(plain->end(), plain_more->begin(), plain_more->end());
    return;
  }
  std::vector<Cell>& cells = general_cells(column);
  for (std::size_t row = 0; row < more.size(); ++row) cells.push_back(more.at(row));
}

void require_same_unit(const Column& column, const Column& more) {
  if (column.unit.empty() || more.unit.empty() || column.unit == more.unit) return;
  throw std::invalid_argument("column '" + column.name + "' is in " + column.unit + " and in " + more.unit);
}

}  // namespace

std::size_t Column::size() const {
  return std::visit([](const auto& list) { return list.size(); }, cells);
}

Cell Column::at(std::size_t row) const {
  return std::visit([&](const auto& list) { return Cell(list.at(row)); }, cells);
}

std::size_t Table::rows() const {
  for (const Column& column : columns) {
    if (column.size() != columns.front().size()) {
      throw std::invalid_argument("column '" + column.name + "' differs in length from '" + columns.front().name + "'");
    }
  }
  return columns.empty() ? 0 : columns.front().size();
}

const Column* Table::find(std::string_view name) const {
  const auto found = std::find_if(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
  return found == columns.end() ? nullptr : &*found;
}

bool is_empty(const Column& column) {
  for (std::size_t i = 0; i < column.size(); ++i) {
    const Cell cell = column.at(i);
    const auto* text = std::get_if<std::string>(&cell);
    if (!std::holds_alternative<std::monostate>(cell) && (text == nullptr || !text->empty())) return false;
  }
  return true;
}

Table one_row(std::vector<std::pair<std::string, Cell>> cells) {
  Table table;
  for (auto& [name, cell] : cells) {
    table.columns.push_back({std::move(name), "", std::vector<Cell>{std::move(cell)}});
  }
  return table;
}

void append(Table& table, const Table& more) {
  const std::size_t old_rows = table.rows();
  const std::size_t new_rows = more.rows();
  for (const Column& column : table.columns) {
    if (const Column* same = more.find(column.name)) require_same_unit(column, *same);
  }
  for (Column& column : table.columns) {
    const Column* same = more.find(column.name);
    if (same != nullptr) append_cells(column, *same);
    if (same != nullptr && column.unit.empty()) column.unit = same->unit;
    if (same == nullptr && new_rows > 0) general_cells(column).resize(old_rows + new_rows);
  }
  for (const Column& column : more.columns) {
    if (table.find(column.name) != nullptr) continue;
    Column fresh = column;
    if (old_rows > 0) {
      std::vector<Cell>& cells = general_cells(fresh);
      cells.insert(cells.begin(), old_rows, Cell());
    }
    table.columns.push_back(std::move(fresh));
  }
}

std::string to_csv(const Table& table, int digits) {
  const std::size_t rows = table.rows();
  if (table.columns.empty()) return "";
  std::string out;
  out.reserve((rows + 1) * table.columns.size() * 20);
  for (const Column& column : table.columns) {
    write_text(column.name, out);
    out += ',';
  }
  out.back() = '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    for (const Column& column : table.columns) {
      if (const auto* plain = std::get_if<std::vector<double>>(&column.cells))
        write_number((*plain)[row], digits, out);
      else
        write_cell(std::get<std::vector<Cell>>(column.cells)[row], digits, out);
      out += ',';
    }
    out.back() = '\n';
  }
  return out;
}

std::string to_markdown(const Table& table, int digits) {
  const std::size_t rows = table.rows();
  std::string out = "|";
  for (const Column& column : table.columns) {
    out += ' ';
    write_markdown_text(column.unit.empty() ? column.name : column.name + " (" + column.unit + ")", out);
    out += " |";
  }
  out += "\n|";
  for (const Column& column : table.columns) out += has_text(column) ? " --- |" : " ---: |";
  out += '\n';
  for (std::size_t row = 0; row < rows; ++row) {
    out += '|';
    for (const Column& column : table.columns) {
      out += ' ';
      write_markdown_cell(column.at(row), digits, out);
      out += "|";
    }
    out += '\n';
  }
  return out;
}

std::string to_text(const Table& table, int digits) {
  const std::size_t rows = table.rows();
  bool units = false;
  for (const Column& column : table.columns) units = units || !column.unit.empty();
  std::vector<std::string> lines(rows + (units ? 2 : 1));
  for (const Column& column : table.columns) {
    std::vector<std::string> cells{column.name};
    if (units) cells.push_back(column.unit);
    for (std::size_t row = 0; row < rows; ++row) write_plain_cell(column.at(row), digits, cells.emplace_back());
    std::size_t width = 0;
    for (const std::string& cell : cells) width = std::max(width, cell.size());
    for (std::size_t i = 0; i < cells.size(); ++i) {
      const std::string padding(width - cells[i].size(), ' ');
      lines[i] += (lines[i].empty() ? "" : "  ") + (has_text(column) ? cells[i] + padding : padding + cells[i]);
    }
  }
  std::string out;
  for (std::string& line : lines) out += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  return out;
}

nlohmann::ordered_json to_json(const Table& table) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  const std::size_t rows = table.rows();
  for (std::size_t row = 0; row < rows; ++row) {
    nlohmann::ordered_json object = nlohmann::ordered_json::object();
    for (const Column& column : table.columns) object[column.name] = cell_to_json(column.at(row));
    list.push_back(std::move(object));
  }
  return list;
}

std::vector<double> numbers(const Table& table, std::string_view name, const std::string& file) {
  const Column* column = table.find(name);
  if (column == nullptr) {
    std::vector<std::string_view> names;
    for (const Column& other : table.columns) names.push_back(other.name);
    throw DataError({.file = file}, "has no column '" + std::string(name) + "', " + suggestion(name, names));
  }
  if (const auto* plain = std::get_if<std::vector<double>>(&column->cells)) return *plain;
  std::vector<double> values;
  for (const Cell& cell : std::get<std::vector<Cell>>(column->cells)) {
    if (const auto* text = std::get_if<std::string>(&cell)) {
      throw DataError({.file = file}, "column '" + std::string(name) + "', row " + std::to_string(values.size() + 1) +
                                          ": '" + shown(*text) + "' must be a number");
    }
    const auto* number = std::get_if<double>(&cell);
    const auto* whole = std::get_if<std::int64_t>(&cell);
    values.push_back(number ? *number : whole ? static_cast<double>(*whole) : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

}  // namespace bayesctrl
