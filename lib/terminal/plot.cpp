#include "terminal/plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "base/format.hpp"

namespace bayesctrl {

namespace {

constexpr int kLabel = 9;  // columns for the range at the left

/// Dots, two by four in each character.
class Canvas {
 public:
  Canvas(int columns, int rows) : columns_(columns), rows_(rows), cells_(static_cast<std::size_t>(columns * rows), 0) {}

  int width() const { return 2 * columns_; }
  int height() const { return 4 * rows_; }

  void dot(int x, int y) {
    constexpr std::uint8_t kBits[4][2] = {{0x01, 0x08}, {0x02, 0x10}, {0x04, 0x20}, {0x40, 0x80}};
    cells_[static_cast<std::size_t>(y / 4 * columns_ + x / 2)] |= kBits[y % 4][x % 2];
  }

  void line(int x0, int y0, int x1, int y1) {
    const int steps = std::max({std::abs(x1 - x0), std::abs(y1 - y0), 1});
    for (int i = 0; i <= steps; ++i) dot(x0 + (x1 - x0) * i / steps, y0 + (y1 - y0) * i / steps);
  }

  /// A row of characters U+2800 and above, as UTF-8.
  std::string row(int r) const {
    std::string text;
    for (int c = 0; c < columns_; ++c) {
      const std::uint8_t bits = cells_[static_cast<std::size_t>(r * columns_ + c)];
      text += '\xe2';
      text += static_cast<char>(0xa0 | (bits >> 6));
      text += static_cast<char>(0x80 | (bits & 0x3f));
    }
    return text;
  }

 private:
  int columns_, rows_;
  std::vector<std::uint8_t> cells_;
};

struct Span {
  double low = 0.0, high = 1.0;

  explicit Span(const std::vector<double>& values) {
    double lowest = kNone, highest = -kNone;
    for (const double value : values) {
      if (!std::isfinite(value)) continue;
      lowest = std::min(lowest, value);
      highest = std::max(highest, value);
    }
    if (lowest > highest) return;
    const double least = 1e-12 * std::max(std::abs(lowest), std::abs(highest));  // a constant is drawn in the middle
    const double margin = highest - lowest > least ? 0.0 : std::max(0.5 * std::abs(highest), 0.5);
    low = lowest - margin;
    high = highest + margin;
  }

  /// Dot from 0 to count - 1.
  int dot(double value, int count) const {
    return std::clamp(static_cast<int>(std::lround((value - low) / (high - low) * (count - 1))), 0, count - 1);
  }

 private:
  static constexpr double kNone = std::numeric_limits<double>::infinity();
};

std::string padded(const std::string& text, std::size_t width) {
  const std::size_t length = shown_length(text);
  return text + std::string(width > length ? width - length : 0, ' ');
}

std::string right(const std::string& text, int width) {
  const auto room = static_cast<std::size_t>(width);
  return std::string(room > text.size() ? room - text.size() : 0, ' ') + text;
}

/// Two texts of several lines side by side.
std::string beside(const std::string& left, const std::string& other, std::size_t width) {
  std::istringstream a(left), b(other);
  std::string text, line_a, line_b;
  while (std::getline(a, line_a) && std::getline(b, line_b)) text += padded(line_a, width) + line_b + "\n";
  return text;
}

}  // namespace

std::size_t shown_length(std::string_view text) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '\033') {
      i = std::min(text.find('m', i), text.size() - 1);
    } else if ((static_cast<unsigned char>(text[i]) & 0xc0) != 0x80) {
      ++count;
    }
  }
  return count;
}

std::string plot(const std::string& title, const std::vector<double>& time, const std::vector<double>& y,
                 const PlotStyle& style) {
  if (time.size() != y.size()) throw std::invalid_argument("a plot needs as many times as values");
  Canvas canvas(std::max(style.width - kLabel - 1, 4), std::max(style.rows, 1));
  const Span across(time), up(y);
  bool before = false;
  int x0 = 0, y0 = 0;
  for (std::size_t i = 0; i < time.size(); ++i) {
    const bool drawn = std::isfinite(time[i]) && std::isfinite(y[i]);
    if (drawn) {
      before = before && time[i] >= time[i - 1];
      const int x1 = across.dot(time[i], canvas.width());
      const int y1 = canvas.height() - 1 - up.dot(y[i], canvas.height());
      canvas.line(before ? x0 : x1, before ? y0 : y1, x1, y1);
      x0 = x1;
      y0 = y1;
    }
    before = drawn;
  }
  std::string text = std::string(kLabel + 1, ' ') + title + "\n";
  for (int row = 0; row < style.rows; ++row) {
    const bool first = row == 0, last = row == style.rows - 1;
    text += right(first ? format(up.high, 3) : last ? format(up.low, 3) : "", kLabel) + " ";
    text += (style.colour ? "\033[36m" : "") + canvas.row(row) + (style.colour ? "\033[0m" : "") + "\n";
  }
  const std::string begin = format(across.low, 3), end = format(across.high, 3) + " s";
  return text + std::string(kLabel + 1, ' ') + begin +
         right(end, std::max(style.width - kLabel - 1 - static_cast<int>(begin.size()), 1)) + "\n";
}

std::string plot_columns(const Table& table, const std::vector<std::string>& columns, const PlotStyle& style) {
  constexpr int kGap = 2;
  PlotStyle half = style;
  half.width = (style.width - kGap) / 2;
  const std::vector<double> time = numbers(table, "t", "plot");
  std::vector<std::string> plots;
  for (const std::string& name : columns) {
    const std::vector<double> values = numbers(table, name, "plot");
    const std::string& unit = table.find(name)->unit;
    plots.push_back(plot(name + (unit.empty() ? "" : " [" + unit + "]"), time, values, half));
  }
  std::string text;
  for (std::size_t i = 0; i < plots.size(); i += 2) {
    text +=
        i + 1 < plots.size() ? beside(plots[i], plots[i + 1], static_cast<std::size_t>(half.width + kGap)) : plots[i];
  }
  return text;
}

}  // namespace bayesctrl
