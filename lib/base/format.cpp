#include "base/format.hpp"

#include <array>
#include <charconv>
#include <cmath>

namespace bayesctrl {

std::string format(double value) {
  if (std::isnan(value)) return "nan";
  std::array<char, 40> buffer{};
  const auto end = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value).ptr;
  return {buffer.data(), end};
}

std::string format(double value, int digits) {
  if (std::isnan(value)) return "nan";
  std::array<char, 400> buffer{};
  const auto end =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, digits).ptr;
  return {buffer.data(), end};
}

std::string padded(std::size_t number, std::size_t digits) {
  const std::string text = std::to_string(number);
  return std::string(text.size() < digits ? digits - text.size() : 0, '0') + text;
}

std::string share_text(double share) { return format(100.0 * share, share < 0.995 ? 2 : 3) + " %"; }

std::string percent_text(double probability) {
  return probability > 0.9995 ? "more than 99.9 %" : format(100.0 * probability, 3) + " %";
}

std::string numbered(std::string_view name, std::ptrdiff_t index, std::ptrdiff_t count) {
  return count == 1 ? std::string(name) : std::string(name) + std::to_string(index + 1);
}

std::string numbered(std::string_view name, std::ptrdiff_t row, std::ptrdiff_t column, std::ptrdiff_t count) {
  return numbered(numbered(name, row, count), column, count);
}

}  // namespace bayesctrl
