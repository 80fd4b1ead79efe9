#include "diagnose/recording/read_recording.hpp"

#include <matio.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>
#include <numbers>
#include <numeric>

#include "base/format.hpp"
#include "diagnose/settings.hpp"
#include "io/files.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

constexpr std::size_t kMaxBytes = std::size_t{1} << 30;

std::string_view trimmed(std::string_view text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == '"'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split(std::string_view line, char separator) {
  std::vector<std::string_view> cells;
  bool quoted = false;
  std::size_t from = 0;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i == line.size() || (line[i] == separator && !quoted)) {
      cells.push_back(trimmed(line.substr(from, i - from)));
      from = i + 1;
    }
  }
  return cells;
}

/// "1", "2", ...: names of columns that have none.
std::vector<std::string> numbered_names(std::size_t count) {
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= count; ++i) names.push_back(std::to_string(i));
  return names;
}

double to_number(std::string_view cell, bool decimal_comma) {
  std::string text(cell);
  if (decimal_comma) std::replace(text.begin(), text.end(), ',', '.');
  const char* begin = text.data();
  if (!text.empty() && *begin == '+') ++begin;
  double value = 0.0;
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size() ? value : std::nan("");
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

std::size_t column_of(const DataTable& table, const Signal& signal, const std::string& file) {
  for (std::size_t i = 0; i < table.names.size(); ++i) {
    if (table.names[i] == signal.column) return i;
  }
  const std::optional<std::size_t> number = parse_integer<std::size_t>(signal.column);
  if (number && *number >= 1 && *number <= table.names.size()) return *number - 1;
  std::vector<std::string_view> names(table.names.begin(), table.names.end());
  throw DataError({file}, "no column '" + shown(signal.column) + "' (named at " + to_string(signal.where) +
                              "): " + suggestion(signal.column, names));
}

/// Takes out jumps by whole turns between samples that follow each other.
void unwrap(std::vector<double>& values, const std::vector<std::size_t>& rows, double turn) {
  double before = values[rows.front()], turns = 0.0;
  for (const std::size_t row : rows) {
    turns -= std::round((values[row] - before) / turn);
    before = values[row];
    values[row] += turns * turn;
  }
}

std::string row_name(const DataTable& table, std::size_t row) {
  return table.lines.empty() ? " row " + std::to_string(row + 1) : "";
}

/// The numbers of one signal, checked in the rows that are wanted; empty: all.
std::vector<double> values_of(const DataTable& table, const Signal& signal, const std::string& file,
                              const std::vector<bool>& wanted = {}) {
  const std::vector<double>& raw = table.columns[column_of(table, signal, file)];
  std::vector<double> values;
  values.reserve(raw.size());
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double value = signal.in_si(raw[i]);
    if (!std::isfinite(value) && (wanted.empty() || wanted[i])) {
      throw DataError({file, table.lines.empty() ? 0 : table.lines[i]},
                      "column '" + shown(signal.column) + "'" + row_name(table, i) +
                          " is missing or not a finite number; cut it out with from and to, or leave the row out");
    }
    values.push_back(value);
  }
  return values;
}

}  // namespace

DataTable parse_data_csv(std::string_view text, const std::string& file) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  if (is_utf16(text)) return parse_data_csv(from_utf16(text), file);
  if (const std::size_t nul = text.find('\0'); nul != std::string_view::npos) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
    throw DataError({file, static_cast<int>(line)},
                    "holds a byte 0: it is no text, or was cut off while it was written");
  }
  const char newline = text.find('\n') == std::string_view::npos ? '\r' : '\n';  // once of the Macintosh
  DataTable table;
  char separator = ',';
  int line_number = 0;
  std::size_t width = 0;
  for (std::size_t from = 0; from < text.size();) {
    std::size_t end = text.find(newline, from);
    if (end == std::string_view::npos) end = text.size();
    std::string_view line = text.substr(from, end - from);
    from = end + 1;
    ++line_number;
    if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
    if (table.names.empty()) {
      separator = separator_of(line);
      std::vector<std::string_view> names = split(line, separator);
      if (!names.empty() && names.back().empty()) names.pop_back();
      if (names.empty()) throw DataError({file, line_number}, "the header names no column");
      const std::vector<std::string> numbers = numbered_names(names.size());
      const bool headless =
          std::ranges::all_of(names, [&](std::string_view n) { return std::isfinite(to_number(n, separator == ';')); });
      if (headless) {
        table.names = numbers;
      } else {
        for (const std::string_view written : names) {
          const std::string name = as_utf8(written);
          if (std::ranges::find(table.names, name) != table.names.end()) {
            throw DataError({file, line_number}, "two columns are named '" + shown(name) + "'");
          }
          table.names.push_back(name);
        }
      }
      width = table.names.size();
      table.columns.resize(width);
      if (!headless || std::ranges::equal(names, numbers)) continue;
    }
    std::vector<std::string_view> cells = split(line, separator);
    if (cells.size() == width + 1 && cells.back().empty()) cells.pop_back();
    if (cells.size() != width) {
      throw DataError({file, line_number},
                      "the row has " + std::to_string(cells.size()) + " cells, the header " + std::to_string(width));
    }
    for (std::size_t i = 0; i < width; ++i) table.columns[i].push_back(to_number(cells[i], separator == ';'));
    table.lines.push_back(line_number);
  }
  if (table.names.empty()) throw DataError({file}, "the file is empty");
  if (table.lines.empty()) throw DataError({file}, "the file has a header and no rows");
  return table;
}

DataTable read_mat(const std::filesystem::path& path) {
  const std::unique_ptr<mat_t, decltype(&Mat_Close)> mat(Mat_Open(path.c_str(), MAT_ACC_RDONLY), &Mat_Close);
  if (mat == nullptr) throw DataError({path.string()}, "not a MATLAB file, or it cannot be read");
  DataTable table;
  const auto add = [&](const std::string& name, const matvar_t* variable) {
    if (variable == nullptr || variable->rank != 2 || variable->data == nullptr || variable->isComplex) return;
    if (variable->class_type < MAT_C_DOUBLE || variable->class_type > MAT_C_UINT64) return;  // no plain numbers
    const std::size_t rows = variable->dims[0], columns = variable->dims[1];
    const bool vector = rows == 1 || columns == 1;
    const auto number = [&](std::size_t i) -> double {
      switch (variable->data_type) {
        case MAT_T_DOUBLE:
          return static_cast<const double*>(variable->data)[i];
        case MAT_T_SINGLE:
          return static_cast<double>(static_cast<const float*>(variable->data)[i]);
        case MAT_T_INT32:
          return static_cast<const std::int32_t*>(variable->data)[i];
        case MAT_T_INT16:
          return static_cast<const std::int16_t*>(variable->data)[i];
        case MAT_T_UINT16:
          return static_cast<const std::uint16_t*>(variable->data)[i];
        case MAT_T_UINT32:
          return static_cast<const std::uint32_t*>(variable->data)[i];
        case MAT_T_INT8:
          return static_cast<const std::int8_t*>(variable->data)[i];
        case MAT_T_UINT8:
          return static_cast<const std::uint8_t*>(variable->data)[i];
        case MAT_T_INT64:
          return static_cast<double>(static_cast<const std::int64_t*>(variable->data)[i]);
        case MAT_T_UINT64:
          return static_cast<double>(static_cast<const std::uint64_t*>(variable->data)[i]);
        default:
          return std::nan("");
      }
    };
    const std::size_t length = vector ? rows * columns : rows;
    for (std::size_t c = 0; c < (vector ? 1 : columns); ++c) {
      std::vector<double> values;
      for (std::size_t i = 0; i < length; ++i) values.push_back(number(c * length + i));
      table.names.push_back(vector ? name : name + "(" + std::to_string(c + 1) + ")");
      table.columns.push_back(std::move(values));
    }
  };
  while (true) {
    const std::unique_ptr<matvar_t, decltype(&Mat_VarFree)> variable(Mat_VarReadNext(mat.get()), &Mat_VarFree);
    if (variable == nullptr) break;
    if (variable->class_type == MAT_C_STRUCT) {
      if (variable->data == nullptr || variable->rank != 2 || variable->dims[0] * variable->dims[1] == 0) continue;
      char* const* fields = Mat_VarGetStructFieldnames(variable.get());
      for (unsigned i = 0; i < Mat_VarGetNumberOfFields(variable.get()); ++i) {
        add(std::string(variable->name) + "." + fields[i], Mat_VarGetStructFieldByIndex(variable.get(), i, 0));
      }
    } else {
      add(variable->name, variable.get());
    }
  }
  if (table.names.empty()) throw DataError({path.string()}, "the file holds no real vectors");
  return table;
}

DataTable read_data_table(const std::filesystem::path& path) {
  if (path.extension() == ".mat" || path.extension() == ".MAT") return read_mat(path);
  return parse_data_csv(read_file(path, kMaxBytes), path.string());
}

Measured read_recording(const RecordingFile& file, const Signals& signals) {
  const std::string path = file.file.string();
  const DataTable table = read_data_table(file.file);
  Measured result;
  result.name = file.name;
  std::vector<std::vector<double>> position, input;
  const std::size_t rows = table.columns[column_of(table, signals.position.front(), path)].size();
  std::vector<double> time;
  if (signals.time.column) {
    time = values_of(table, *signals.time.column, path);
  } else {
    for (std::size_t i = 0; i < rows; ++i) time.push_back(static_cast<double>(i) / signals.time.rate);
  }
  std::vector<bool> wanted;
  for (const double t : time) wanted.push_back(!(file.from && t < *file.from) && !(file.to && t > *file.to));
  wanted.resize(std::max(wanted.size(), rows), true);
  for (const Signal& signal : signals.position) position.push_back(values_of(table, signal, path, wanted));
  for (const Signal& signal : signals.input) {
    const std::size_t length = table.columns[column_of(table, signal, path)].size();
    if (length != rows) throw DataError({path}, "the signals differ in length");
    input.push_back(values_of(table, signal, path, wanted));
    result.linear_hold |= signal.hold == Hold::linear;
  }
  for (const auto* list : {&position, &input}) {
    for (const std::vector<double>& values : *list) {
      if (values.size() != rows || time.size() != rows) throw DataError({path}, "the signals differ in length");
    }
  }
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < rows; ++i) {
    if (i > 0 && time[i] < time[i - 1]) {
      throw DataError({path, table.lines.empty() ? 0 : table.lines[i]},
                      "time runs backwards, from " + format(time[i - 1], 9) + " to " + format(time[i], 9) + " s");
    }
    if (file.from && time[i] < *file.from) continue;
    if (file.to && time[i] > *file.to) continue;
    if (!kept.empty() && time[i] == time[kept.back()]) continue;
    kept.push_back(i);
  }
  if (const auto chosen = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), true));
      2 * kept.size() < chosen && chosen >= std::size_t{kSettings.recording.fewest_samples}) {
    throw DataError({path}, "only " + std::to_string(kept.size()) + " of " + std::to_string(chosen) +
                                " rows have a time of their own: the column stands still, or is too coarse");
  }
  if (kept.size() < std::size_t{kSettings.recording.fewest_samples}) {
    throw DataError({path}, "only " + std::to_string(kept.size()) + " samples" +
                                (file.from || file.to ? " between from and to" : "") + ": too short a recording");
  }
  for (std::size_t j = 0; j < position.size(); ++j) {
    if (signals.position[j].unwrap) unwrap(position[j], kept, 2.0 * std::numbers::pi);
  }
  const auto samples = static_cast<Eigen::Index>(kept.size());
  const auto joints = static_cast<Eigen::Index>(position.size());
  result.position.resize(samples, joints);
  result.input.resize(samples, joints);
  result.start = time[kept.front()];
  for (Eigen::Index i = 0; i < samples; ++i) {
    const std::size_t row = kept[static_cast<std::size_t>(i)];
    result.time.push_back(time[row] - result.start);
    for (Eigen::Index j = 0; j < joints; ++j) {
      result.position(i, j) = position[static_cast<std::size_t>(j)][row];
      result.input(i, j) = input[static_cast<std::size_t>(j)][row];
    }
  }
  return result;
}

Eigen::MatrixXd read_simulation(const RecordingFile& file, const Signals& signals, const Measured& measured) {
  RecordingFile other = file;
  other.file = file.simulation;
  other.from.reset();
  other.to.reset();
  const std::string path = other.file.string();
  const DataTable table = read_data_table(other.file);
  std::vector<double> time;
  std::vector<std::vector<double>> position;
  for (const Signal& signal : signals.position) position.push_back(values_of(table, signal, path));
  if (signals.time.column) {
    time = values_of(table, *signals.time.column, path);
  } else {
    for (std::size_t i = 0; i < position.front().size(); ++i)
      time.push_back(static_cast<double>(i) / signals.time.rate);
  }
  for (const std::vector<double>& q : position) {
    if (q.size() != time.size()) throw DataError({path}, "the signals differ in length");
  }
  std::vector<std::size_t> rows(time.size());
  std::iota(rows.begin(), rows.end(), std::size_t{0});
  for (std::size_t j = 0; j < position.size(); ++j) {
    if (signals.position[j].unwrap) unwrap(position[j], rows, 2.0 * std::numbers::pi);
  }
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (time[i] < time[i - 1]) {
      throw DataError({path, table.lines.empty() ? 0 : table.lines[i]}, "time runs backwards");
    }
  }
  const double first = measured.start, last = measured.start + measured.time.back(), slack = sample_period(time);
  if (time.front() > first + slack || time.back() < last - slack) {
    throw DataError({path}, "the simulation covers " + format(time.front(), 6) + " to " + format(time.back(), 6) +
                                " s, the recording " + format(first, 6) + " to " + format(last, 6) + " s");
  }
  Eigen::MatrixXd result(measured.position.rows(), measured.position.cols());
  for (Eigen::Index k = 0; k < result.rows(); ++k) {
    const double t = measured.start + measured.time[static_cast<std::size_t>(k)];
    const auto after = static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    const std::size_t i = std::clamp<std::size_t>(after, 1, time.size() - 1);
    const double s = std::clamp((t - time[i - 1]) / std::max(time[i] - time[i - 1], 1e-12), 0.0, 1.0);
    for (Eigen::Index j = 0; j < result.cols(); ++j) {
      const std::vector<double>& q = position[static_cast<std::size_t>(j)];
      result(k, j) = (1.0 - s) * q[i - 1] + s * q[i];
    }
  }
  return result;
}

}  // namespace bayesctrl
