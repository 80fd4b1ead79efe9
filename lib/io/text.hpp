#pragma once

#include <charconv>
#include <concepts>
#include <optional>
#include <string>
#include <string_view>

#include "base/fields.hpp"

namespace bayesctrl {

/// Position of the first byte that is not well-formed UTF-8 (RFC 3629), or that is a control character other than tab,
/// line feed and carriage return; npos when there is none.
std::size_t first_unreadable(std::string_view text);

/// `text` if it is UTF-8, else what it is as Latin-1 (ISO 8859-1), in UTF-8. Control characters stay.
std::string as_utf8(std::string_view text);

/// Whether `text` begins with a mark of UTF-16; the same text in UTF-8. What is no pair of surrogates is left out.
bool is_utf16(std::string_view text);
std::string from_utf16(std::string_view text);

/// `text` for use inside one line of a message: control characters as '?', cut after `limit` bytes.
std::string shown(std::string_view text, std::size_t limit = 60);

/// `text` as one word of a shell's command line.
std::string shell_quoted(std::string_view text);

/// "a whole number of at least 1": the words of `to_string(range)` for whole numbers.
std::string whole_number(const Range& range);

/// `range` without its negative numbers if T has none.
template <std::integral T>
Range admitted(Range range) {
  if (std::unsigned_integral<T> && range.low < 0.0) range.low = 0.0;
  return range;
}

/// Decimal notation of YAML 1.2: [+-]digits[.digits][e[+-]digits] or [+-].digits, but no leading zeros.
bool is_decimal(std::string_view text);

/// [+-]digits, no leading zeros.
bool is_whole(std::string_view text);

/// The number that `text` writes in decimal. Empty for any other notation and for what no double can hold: 1e400, and
/// 1e-400, which would become 0.
std::optional<double> parse_double(std::string_view text);

/// The same for whole numbers. Empty beyond the range of T.
template <std::integral T>
std::optional<T> parse_integer(std::string_view text) {
  if (!is_whole(text)) return std::nullopt;
  if (text.front() == '+') text.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace bayesctrl
