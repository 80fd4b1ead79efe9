#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "base/error.hpp"
#include "diagnose/recording/data_table.hpp"
#include "io/files.hpp"
#include "io/lines.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

/// Puts the cells of a line there.
void split(std::string_view line, char separator, std::vector<std::string_view>& cells) {
  cells.clear();
  bool quoted = false;
  std::size_t from = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i == line.size() || (line[i] == separator && !quoted)) {
      cells.push_back(trimmed(line.substr(from, i - from)));
      from = i + 1;
    }
  }
}

/// "1", "2", ...: names of columns that have none.
std::vector<std::string> numbered_names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back(std::to_string(i));
  return names;
}

double to_number(std::string_view cell) {
  if (cell.starts_with('+')) cell.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} && end == cell.data() + cell.size() ? value : std::nan("");
}

char separator_of(std::string_view header) {
  char best = ',';
  std::ptrdiff_t most = 0;
  for (const char candidate : {',', ';', '\t'}) {
    const auto count = std::count(header.begin(), header.end(), candidate);
    if (count > most) {
      most = count;
      best = candidate;
    }
  }
  return best;
}

/// Rows of a table, one after the other, below its header.
class CsvRows {
 public:
  CsvRows(Lines::Read read, const std::string& file) : lines_(std::move(read), file), file_(file) {}

  /// The next row, which is not taken apart yet; false at the end.
  bool next() {
    if (std::exchange(again_, false)) return true;
    while (lines_.next(line_)) {
      const std::string_view text = trimmed(line_);
      if (!text.empty() && text.front() != '#') return true;
    }
    return false;
  }

  /// The names of the columns, once before any row. A first line of numbers is a row as well.
  std::vector<std::string> header() {
    if (!next()) throw DataError({file_}, "the file is empty");
    refuse_nul();
    separator_ = separator_of(line_);
    split(line_, separator_, cells_);
    if (!cells_.empty() && cells_.back().empty()) cells_.pop_back();
    if (cells_.empty()) throw DataError({file_, line()}, "the header names no column");
    const std::vector<std::string> numbers = numbered_names(cells_.size());
    width_ = cells_.size();
    const bool headless =
        std::ranges::all_of(cells_, [&](std::string_view cell) { return std::isfinite(in_cell(cell)); });
    if (headless) {
      again_ = !std::ranges::equal(cells_, numbers);
      return numbers;
    }
    std::vector<std::string> names;
    for (const std::string_view written : cells_) {
      const std::string name = as_utf8(written);
      if (std::ranges::find(names, name) != names.end()) {
        throw DataError({file_, line()}, "two columns are named '" + shown(name) + "'");
      }
      names.push_back(name);
    }
    return names;
  }

  /// Takes the row apart. Throws DataError where it is no row of the table.
  void take_apart() {
    refuse_nul();
    split(line_, separator_, cells_);
    if (cells_.size() == width_ + 1 && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == width_) return;
    throw DataError({file_, line()},
                    "the row has " + std::to_string(cells_.size()) + " cells, the header " + std::to_string(width_));
  }

  double number(std::size_t column) const { return in_cell(cells_[column]); }
  int line() const { return lines_.number(); }

 private:
  double in_cell(std::string_view cell) const {
    if (separator_ != ';' || cell.find(',') == std::string_view::npos) return to_number(cell);
    std::string text(cell);
    std::replace(text.begin(), text.end(), ',', '.');
    return to_number(text);
  }

  void refuse_nul() const {
    if (line_.find('\0') == std::string_view::npos) return;
    throw DataError({file_, line()}, "holds a byte 0: it is no text, or was cut off while it was written");
  }

  Lines lines_;
  const std::string& file_;
  std::string_view line_;
  std::vector<std::string_view> cells_;
  std::size_t width_ = 0;
  char separator_ = ',';
  bool again_ = false;
};

/// Rows of which there may be too many: of those the first piece, then every second, fourth, ... one.
class Pieces {
 public:
  Pieces(DataTable& table, std::vector<std::size_t> columns, const Wanted& wanted)
      : table_(table),
        columns_(std::move(columns)),
        length_(std::max<std::size_t>(1, wanted.numbers / columns_.size() / wanted.pieces)),
        most_(length_ * wanted.pieces) {}

  /// Whether the next row that counts stays.
  bool keeps_next() {
    const std::size_t next = offered_++;
    if (next / length_ % every_ == 0 && table_.lines.size() == most_) halve();
    const bool stays = next / length_ % every_ == 0;
    if (!stays) ++table_.left_out;
    return stays;
  }

  void keep(const CsvRows& row, std::size_t number) {
    for (const std::size_t c : columns_) table_.columns[c].push_back(row.number(c));
    table_.lines.push_back(row.line());
    table_.rows.push_back(number);
  }

 private:
  /// Of the pieces that were kept every second one stays.
  void halve() {
    every_ *= 2;
    const auto halved = [&](auto& list) {
      std::size_t to = 0;
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (i / length_ % 2 == 0) list[to++] = list[i];
      }
      list.resize(to);
    };
    const std::size_t before = table_.lines.size();
    for (const std::size_t c : columns_) halved(table_.columns[c]);
    halved(table_.lines);
    halved(table_.rows);
    table_.left_out += before - table_.lines.size();
  }

  DataTable& table_;
  std::vector<std::size_t> columns_;
  std::size_t length_, most_;
  std::size_t every_ = 1, offered_ = 0;
};

DataTable read_csv(Lines::Read read, const std::string& file, const Wanted& wanted) {
  CsvRows rows(std::move(read), file);
  DataTable table;
  table.names = rows.header();
  table.columns.resize(table.names.size());
  std::vector<std::size_t> columns;
  for (const std::string& name : wanted.columns) {
    const std::optional<std::size_t> found = table.find(name);
    if (!found) return table;  // what is asked for is not there
    if (std::ranges::find(columns, *found) == columns.end()) columns.push_back(*found);
  }
  if (wanted.columns.empty()) {
    for (std::size_t c = 0; c < table.names.size(); ++c) columns.push_back(c);
  }
  Pieces pieces(table, columns, wanted);
  std::size_t number = 0;
  for (; rows.next(); ++number) {
    if (wanted.counts) {
      rows.take_apart();
      if (!wanted.counts(number, rows.number(columns.front()))) continue;
    }
    if (!pieces.keeps_next()) continue;
    if (!wanted.counts) rows.take_apart();
    pieces.keep(rows, number);
  }
  if (number == 0) throw DataError({file}, "the file has a header and no rows");
  return table;
}

}  // namespace

std::optional<std::size_t> DataTable::find(const std::string& column) const {
  const auto at = std::ranges::find(names, column);
  if (at != names.end()) return static_cast<std::size_t>(at - names.begin());
  const std::optional<std::size_t> number = parse_integer<std::size_t>(column);
  return number && *number >= 1 && *number <= names.size() ? std::optional(*number - 1) : std::nullopt;
}

DataTable parse_data_csv(std::string_view text, const std::string& file, const Wanted& wanted) {
  const auto read = [&text](char* to, std::size_t size) {
    const std::size_t count = text.copy(to, size);
    text.remove_prefix(count);
    return count;
  };
  return read_csv(read, file, wanted);
}

DataTable read_data_table(const std::filesystem::path& path, const Wanted& wanted) {
  if (path.extension() == ".mat" || path.extension() == ".MAT") return read_mat(path);
  FileReader file(path);
  return read_csv([&](char* to, std::size_t size) { return file.read(to, size); }, path.string(), wanted);
}

}  // namespace bayesctrl
