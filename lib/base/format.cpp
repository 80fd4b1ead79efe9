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

}  // namespace bayesctrl
