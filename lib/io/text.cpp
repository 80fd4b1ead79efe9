#include "io/text.hpp"

#include <algorithm>
#include <boost/locale/encoding_utf.hpp>

namespace bayesctrl {

namespace {

bool is_digit(char letter) { return letter >= '0' && letter <= '9'; }
bool is_control(unsigned char byte) { return byte < 0x20 || byte == 0x7f; }

/// Length of the UTF-8 sequence that starts at `at`, 0 if it is malformed, overlong, a surrogate or beyond U+10FFFF.
std::size_t sequence_length(std::string_view text, std::size_t at) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[at + i]); };
  const unsigned char lead = byte(0);
  if (lead < 0x80) return 1;
  const std::size_t length = lead >= 0xf0 ? 4 : lead >= 0xe0 ? 3 : 2;
  if (lead < 0xc2 || lead > 0xf4 || at + length > text.size()) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if ((byte(i) & 0xc0) != 0x80) return 0;
  }
  const bool overlong = (lead == 0xe0 && byte(1) < 0xa0) || (lead == 0xf0 && byte(1) < 0x90);
  const bool surrogate = lead == 0xed && byte(1) > 0x9f;
  const bool beyond = lead == 0xf4 && byte(1) > 0x8f;
  return overlong || surrogate || beyond ? 0 : length;
}

std::string_view without_sign(std::string_view text) {
  if (!text.empty() && (text.front() == '+' || text.front() == '-')) text.remove_prefix(1);
  return text;
}

/// Takes the leading digits off `text` and returns how many there were.
std::size_t take_digits(std::string_view& text) {
  const auto end = std::find_if_not(text.begin(), text.end(), is_digit);
  const auto count = static_cast<std::size_t>(end - text.begin());
  text.remove_prefix(count);
  return count;
}

}  // namespace

std::size_t first_unreadable(std::string_view text) {
  for (std::size_t at = 0; at < text.size();) {
    const auto byte = static_cast<unsigned char>(text[at]);
    if (is_control(byte) && byte != '\t' && byte != '\n' && byte != '\r') return at;
    const std::size_t length = sequence_length(text, at);
    if (length == 0) return at;
    at += length;
  }
  return std::string_view::npos;
}

std::string as_utf8(std::string_view text) {
  bool well_formed = true;
  for (std::size_t at = 0, length = 0; well_formed && at < text.size(); at += length) {
    length = sequence_length(text, at);
    well_formed = length > 0;
  }
  if (well_formed) return std::string(text);
  std::string result;
  for (const char letter : text) {
    const auto byte = static_cast<unsigned char>(letter);
    if (byte < 0x80) {
      result += letter;
    } else {
      result += static_cast<char>(0xc0 | (byte >> 6));
      result += static_cast<char>(0x80 | (byte & 0x3f));
    }
  }
  return result;
}

bool is_utf16(std::string_view text) { return text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF"); }

std::string from_utf16(std::string_view text) {
  const std::size_t high = text.front() == '\xFE' ? 0 : 1;
  std::u16string wide;
  for (std::size_t i = 2; i + 1 < text.size(); i += 2) {
    const auto byte = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
    wide += static_cast<char16_t>(byte(high) << 8 | byte(1 - high));
  }
  return boost::locale::conv::utf_to_utf<char>(wide);
}

std::string shown(std::string_view text, std::size_t limit) {
  std::size_t end = std::min(text.size(), limit);
  while (end < text.size() && end > 0 && (static_cast<unsigned char>(text[end]) & 0xc0) == 0x80) --end;
  std::string result(text.substr(0, end));
  std::replace_if(
      result.begin(), result.end(), [](char c) { return is_control(static_cast<unsigned char>(c)); }, '?');
  return end < text.size() ? result + "..." : result;
}

std::string shell_quoted(std::string_view text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

std::string whole_number(const Range& range) { return "a whole" + to_string(range).substr(1); }

bool is_decimal(std::string_view text) {
  text = without_sign(text);
  const bool leading_zero = text.size() > 1 && text[0] == '0' && is_digit(text[1]);
  std::size_t digits = take_digits(text);
  if (!text.empty() && text.front() == '.') {
    text.remove_prefix(1);
    digits += take_digits(text);
  }
  if (digits == 0 || leading_zero) return false;
  if (text.empty()) return true;
  if (text.front() != 'e' && text.front() != 'E') return false;
  text = without_sign(text.substr(1));
  return take_digits(text) > 0 && text.empty();
}

bool is_whole(std::string_view text) {
  const std::string_view digits = without_sign(text);
  return is_decimal(text) && std::all_of(digits.begin(), digits.end(), is_digit);
}

std::optional<double> parse_double(std::string_view text) {
  if (!is_decimal(text)) return std::nullopt;
  if (text.front() == '+') text.remove_prefix(1);
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);  // refuses 1e-400 too
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace bayesctrl
