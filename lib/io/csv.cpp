#include <algorithm>
#include <limits>
#include <optional>

#include "base/error.hpp"
#include "base/fields.hpp"
#include "io/files.hpp"
#include "io/table.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kMaxCsvBytes = std::size_t{1} << 28;

/// Cells of a CSV text one by one, with the line on which each stands.
class CsvScanner {
 public:
  CsvScanner(std::string_view rest, const std::string& file) : rest_(rest), file_(file) {}

  bool done() const { return rest_.empty(); }
  Location where() const { return {.file = file_, .line = line_}; }

  /// The next row into `cells`; a text in quotes as it is, any other by what it looks like.
  void next_row(std::vector<Cell>& cells) {
    cells.clear();
    bool more = true;
    while (more) {
      cells.push_back(rest_.starts_with('"') ? Cell(quoted_text()) : plain_cell());
      more = rest_.starts_with(',');
      if (more) rest_.remove_prefix(1);
    }
    if (rest_.starts_with("\r\n")) rest_.remove_prefix(1);
    if (!rest_.empty() && rest_.front() != '\n')
      throw DataError(where(), "expected ',' or the end of the line after \"");
    if (!rest_.empty()) rest_.remove_prefix(1);
    ++line_;
  }

 private:
  std::string quoted_text() {
    const Location start = where();
    std::string text;
    rest_.remove_prefix(1);
    while (true) {
      const std::size_t end = rest_.find('"');
      if (end == std::string_view::npos) throw DataError(start, "this quote is never closed");
      text += rest_.substr(0, end);
      line_ += static_cast<int>(std::count(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
      rest_.remove_prefix(end + 1);
      if (!rest_.starts_with('"')) return text;
      text += '"';  // a doubled quote
      rest_.remove_prefix(1);
    }
  }

  Cell plain_cell() {
    std::string_view text = rest_.substr(0, rest_.find_first_of(",\n"));
    rest_.remove_prefix(text.size());
    if (text.ends_with('\r') && !rest_.starts_with(',')) text.remove_suffix(1);
    if (text.find('"') != std::string_view::npos) throw DataError(where(), "a quote inside '" + shown(text) + "'");
    if (text.empty()) return {};
    if (const auto whole = parse_integer<std::int64_t>(text); whole && text != "-0") return *whole;
    if (const auto number = parse_double(text)) return *number;
    if (text == "nan") return std::numeric_limits<double>::quiet_NaN();
    if (text == "inf") return kInfinity;
    if (text == "-inf") return -kInfinity;
    return std::string(text);
  }

  std::string_view rest_;
  const std::string& file_;
  int line_ = 1;
};

Table table_with_header(CsvScanner& scanner) {
  const Location where = scanner.where();
  std::vector<Cell> names;
  scanner.next_row(names);
  Table table;
  for (const Cell& cell : names) {
    const auto* name = std::get_if<std::string>(&cell);
    if (name == nullptr || name->empty()) throw DataError(where, "the header must give each column a name");
    if (table.find(*name) != nullptr) throw DataError(where, "column '" + shown(*name) + "' is repeated");
    table.columns.push_back({.name = *name, .cells = std::vector<Cell>{}});
  }
  return table;
}

/// Numbers of which at least one is not whole become doubles.
void make_numeric(Column& column) {
  const auto& cells = std::get<std::vector<Cell>>(column.cells);
  std::vector<double> values;
  bool any_double = false;
  for (const Cell& cell : cells) {
    const auto* number = std::get_if<double>(&cell);
    const auto* whole = std::get_if<std::int64_t>(&cell);
    if (number == nullptr && whole == nullptr) return;
    any_double = any_double || number != nullptr;
    values.push_back(number ? *number : static_cast<double>(*whole));
  }
  if (any_double) column.cells = std::move(values);
}

}  // namespace

Table parse_csv(std::string_view text, const std::string& file) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);  // byte-order mark
  CsvScanner scanner(text, file);
  if (scanner.done()) throw DataError({.file = file}, "is empty");
  Table table = table_with_header(scanner);
  std::vector<Cell> row;
  while (!scanner.done()) {
    const Location where = scanner.where();
    scanner.next_row(row);
    if (row.size() != table.columns.size()) {
      throw DataError(
          where, "has " + std::to_string(row.size()) + " cells, the header " + std::to_string(table.columns.size()));
    }
    for (std::size_t i = 0; i < row.size(); ++i) {
      std::get<std::vector<Cell>>(table.columns[i].cells).push_back(std::move(row[i]));
    }
  }
  for (Column& column : table.columns) make_numeric(column);
  return table;
}

Table read_csv(const std::filesystem::path& path) { return parse_csv(read_file(path, kMaxCsvBytes), path.string()); }

}  // namespace bayesctrl
