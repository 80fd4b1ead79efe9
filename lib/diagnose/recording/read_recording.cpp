#include "diagnose/recording/read_recording.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "base/format.hpp"
#include "diagnose/recording/data_table.hpp"
#include "diagnose/settings.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

std::size_t column_of(const DataTable& table, const Signal& signal, const std::string& file) {
  if (const std::optional<std::size_t> found = table.find(signal.column)) return *found;
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

/// The columns of a spec in the rows of a file between from and to; of a long file pieces, unless turns have to be
/// counted through all of it. Must not outlive the file.
Wanted wanted_of(const RecordingFile& file, const Signals& signals) {
  Wanted wanted;
  if (signals.time.column) wanted.columns.push_back(signals.time.column->column);
  bool turns = false;
  for (const PositionSignal& signal : signals.position) {
    wanted.columns.push_back(signal.column);
    turns |= signal.unwrap;
  }
  for (const InputSignal& signal : signals.input) wanted.columns.push_back(signal.column);
  for (const Signal& signal : signals.temperature) wanted.columns.push_back(signal.column);
  if (!turns) {
    wanted.numbers = kSettings.recording.numbers;
    wanted.pieces = kSettings.recording.pieces;
  }
  if (!file.from && !file.to) return wanted;
  const auto time = signals.time.column ? std::optional(signals.time.column->to_si()) : std::nullopt;
  wanted.counts = [time, rate = signals.time.rate, &file](std::size_t row, double first) {
    return file.holds(time ? (*time)(first) : static_cast<double>(row) / rate);
  };
  return wanted;
}

/// Rows without those at the beginning and at the end that stand alone: too few for any run without a gap. Throws
/// DataError for a gap that only a clock that was set can have left: beside so much, times between samples are rounded
/// off.
std::vector<std::size_t> without_strays(std::vector<std::size_t> kept, const std::vector<double>& time,
                                        const DataTable& table, const std::string& file) {
  Measured at;
  for (const std::size_t row : kept) at.time.push_back(time[row]);
  const std::vector<Segment> all = stretches(at, 0);
  const auto used = [](const Segment& stretch) { return stretch.samples() >= kFewestInWindow; };
  const auto first = std::ranges::find_if(all, used);
  if (first == all.end()) return kept;
  const Segment last = *std::find_if(all.rbegin(), all.rend(), used);
  double recorded = 0.0;
  for (const Segment& stretch : all) recorded += time[kept[stretch.last]] - time[kept[stretch.first]];
  for (auto next = first; next->last < last.last;) {
    const std::size_t before = kept[next->last], row = kept[(++next)->first];
    const double pause = time[row] - time[before];
    if (pause < kSettings.recording.longest_pause || pause < kSettings.recording.longest_share * recorded) continue;
    throw DataError({file, table.lines.empty() ? 0 : table.lines[row]},
                    "time jumps from " + format(time[before], 9) + " to " + format(time[row], 12) +
                        " s: the clock was set; choose what lies before or behind with from and to");
  }
  kept.resize(last.last + 1);
  kept.erase(kept.begin(), kept.begin() + static_cast<std::ptrdiff_t>(first->first));
  return kept;
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
  const auto in_si = signal.to_si();
  for (std::size_t i = 0; i < raw.size(); ++i) {
    const double value = in_si(raw[i]);
    if (!std::isfinite(value) && (wanted.empty() || wanted[i])) {
      throw DataError({file, table.lines.empty() ? 0 : table.lines[i]},
                      "column '" + shown(signal.column) + "'" + row_name(table, i) +
                          " is missing or not a finite number; cut it out with from and to, or leave the row out");
    }
    values.push_back(value);
  }
  return values;
}

/// The mean about each sample over a window that is as long before as after it.
Temperature averaged(const Temperature& seen) {
  const double window = 0.5 * kSettings.recording.temperature;  // to either side
  Temperature result = seen;
  const auto count = static_cast<std::size_t>(seen.celsius.rows());
  Eigen::MatrixXd sums = Eigen::MatrixXd::Zero(seen.celsius.rows() + 1, seen.celsius.cols());
  for (Eigen::Index i = 0; i < seen.celsius.rows(); ++i) sums.row(i + 1) = sums.row(i) + seen.celsius.row(i);
  std::size_t half = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const auto within = [&](std::size_t reach) {
      return reach <= i && i + reach < count && seen.time[i] - seen.time[i - reach] <= window &&
             seen.time[i + reach] - seen.time[i] <= window;
    };
    while (!within(half)) --half;
    while (within(half + 1)) ++half;
    const auto first = static_cast<Eigen::Index>(i - half), last = static_cast<Eigen::Index>(i + half);
    result.celsius.row(static_cast<Eigen::Index>(i)) =
        (sums.row(last + 1) - sums.row(first)) / static_cast<double>(last + 1 - first);
  }
  return result;
}

/// Sensors of temperature are coarse and noisy, machines warm slowly. What an average takes off a curve one more tells.
Temperature smoothed(const Temperature& seen) {
  Temperature once = averaged(seen);
  const Temperature twice = averaged(once);
  once.celsius = 2.0 * once.celsius - twice.celsius;
  return once;
}

/// Of every joint at the times of the recording, from the rows that have it.
RecordedTemperature temperature_of(const DataTable& table, const Signals& signals, const RecordingFile& of,
                                   const std::vector<double>& time, const Measured& recording) {
  const std::string file = of.file.string();
  if (signals.temperature.empty()) return {};
  Temperature result{recording.time, Eigen::MatrixXd(recording.position.rows(), recording.position.cols())};
  for (Eigen::Index j = 0; j < result.celsius.cols(); ++j) {
    const Signal& signal = signals.temperature[signals.temperature.size() == 1 ? 0 : static_cast<std::size_t>(j)];
    const std::vector<double>& column = table.columns[column_of(table, signal, file)];
    if (column.size() != time.size()) throw DataError({file}, "the signals differ in length");
    const auto in_celsius = signal.to_si();
    Temperature known;
    std::vector<double> values;
    for (std::size_t row = 0; row < column.size(); ++row) {
      const double t = time[row] - recording.start;
      if (!std::isfinite(column[row]) || (!known.time.empty() && t <= known.time.back())) continue;
      known.time.push_back(t);
      values.push_back(in_celsius(column[row]));
    }
    if (values.empty())
      throw DataError({file}, "column '" + shown(signal.column) + "' has no number " +
                                  (of.from || of.to ? "between from and to" : "in it"));
    known.celsius = Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
    const Temperature smooth = smoothed(known);
    for (Eigen::Index k = 0; k < result.celsius.rows(); ++k) {
      result.celsius(k, j) = smooth.at(0, recording.time[static_cast<std::size_t>(k)]);
    }
  }
  return std::make_shared<const Temperature>(std::move(result));
}

}  // namespace

Measured read_recording(const RecordingFile& file, const Signals& signals) {
  const std::string path = file.file.string();
  const DataTable table = read_data_table(file.file, wanted_of(file, signals));
  Measured result;
  result.left_out = table.left_out;
  result.name = file.name;
  std::vector<std::vector<double>> position, input;
  const std::size_t rows = table.columns[column_of(table, signals.position.front(), path)].size();
  std::vector<double> time;
  if (signals.time.column) {
    time = values_of(table, *signals.time.column, path);
  } else {
    for (std::size_t i = 0; i < rows; ++i) {
      time.push_back(static_cast<double>(table.rows.empty() ? i : table.rows[i]) / signals.time.rate);
    }
  }
  std::vector<bool> wanted;
  for (const double t : time) wanted.push_back(file.holds(t));
  wanted.resize(std::max(wanted.size(), rows), true);
  for (const Signal& signal : signals.position) position.push_back(values_of(table, signal, path, wanted));
  for (const Signal& signal : signals.input) {
    const std::size_t length = table.columns[column_of(table, signal, path)].size();
    if (length != rows) throw DataError({path}, "the signals differ in length");
    input.push_back(values_of(table, signal, path, wanted));
    result.linear_hold |= signal.hold == Hold::linear;
  }
  for (const Signal& signal : signals.temperature) column_of(table, signal, path);
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
    if (!file.holds(time[i])) continue;
    if (!kept.empty() && time[i] == time[kept.back()]) continue;
    kept.push_back(i);
  }
  if (const auto chosen = static_cast<std::size_t>(std::count(wanted.begin(), wanted.end(), true));
      2 * kept.size() < chosen) {
    throw DataError({path}, "only " + std::to_string(kept.size()) + " of " + std::to_string(chosen) +
                                " rows have a time of their own: the column stands still, or is too coarse");
  }
  if (kept.size() < std::size_t{kSettings.recording.fewest_samples}) {
    throw DataError({path}, "only " + std::to_string(kept.size()) + " samples" +
                                (file.from || file.to ? " between from and to" : "") + ": too short a recording");
  }
  kept = without_strays(std::move(kept), time, table, path);
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
  result.temperature = temperature_of(table, signals, file, time, result);
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
