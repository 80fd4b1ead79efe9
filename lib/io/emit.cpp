#include "io/emit.hpp"

#include <algorithm>
#include <array>
#include <cctype>

#include "base/format.hpp"

namespace bayesctrl {

using nlohmann::ordered_json;

namespace {

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }
bool is_plain_inside(char c) {
  return is_letter(c) || (c >= '0' && c <= '9') || std::string_view("_-./+() ").find(c) != std::string_view::npos;
}

/// Words that some YAML reader takes for null, a truth value or a number.
bool is_reserved(std::string_view text) {
  std::string lower(text);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  constexpr std::array<std::string_view, 11> kReserved{"null", "true", "false", "yes", "no", "on",
                                                       "off",  "y",    "n",     "inf", "nan"};
  return std::find(kReserved.begin(), kReserved.end(), lower) != kReserved.end();
}

/// Whether the text may stand without quotes, in block and in flow style.
bool is_plain_text(std::string_view text) {
  if (text == ".inf" || text == "-.inf") return true;  // see number_to_json
  if (text.empty() || !(is_letter(text.front()) || text.front() == '_') || text.back() == ' ') return false;
  return std::all_of(text.begin(), text.end(), is_plain_inside) && !is_reserved(text);
}

std::string hex_escape(unsigned char c) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  return {'\\', 'x', kDigits[c >> 4], kDigits[c & 15]};
}

/// The character at the start of `rest` as it stands in double quotes; `length` becomes its length in bytes. Escaped is
/// what a YAML reader would refuse or take for a line break: C0 and C1 controls, U+2028, U+2029, U+FEFF.
std::string escaped(std::string_view rest, std::size_t& length) {
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(rest[i]); };
  length = 3;
  if (rest.starts_with("\xe2\x80\xa8")) return "\\u2028";
  if (rest.starts_with("\xe2\x80\xa9")) return "\\u2029";
  if (rest.starts_with("\xef\xbb\xbf")) return "\\ufeff";
  length = 2;
  if (byte(0) == 0xc2 && rest.size() > 1 && byte(1) < 0xa0) return hex_escape(byte(1));
  length = 1;
  if (rest[0] == '\n') return "\\n";
  if (rest[0] == '"' || rest[0] == '\\') return {'\\', rest[0]};
  if (byte(0) < 0x20 || byte(0) == 0x7f) return hex_escape(byte(0));
  return {rest[0]};
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  std::size_t length = 0;
  for (; !text.empty(); text.remove_prefix(length)) result += escaped(text, length);
  return result + '"';
}

std::string text_to_yaml(const std::string& text) { return is_plain_text(text) ? text : in_quotes(text); }

/// YAML 1.1 knows numbers with an exponent only if they have a point: 1e-05 becomes 1.0e-05.
std::string number_to_yaml(double value) {
  std::string text = format(value);
  const std::size_t exponent = text.find('e');
  if (exponent != std::string::npos && text.find('.') == std::string::npos) text.insert(exponent, ".0");
  return text;
}

std::string scalar_to_yaml(const ordered_json& value) {
  if (value.is_string()) return text_to_yaml(value.get_ref<const std::string&>());
  if (!value.is_number_float()) return value.dump();
  const ordered_json number = number_to_json(value.get<double>());
  return number.is_number() ? number_to_yaml(value.get<double>()) : scalar_to_yaml(number);
}

/// Whether the value stands in one line also in block style.
bool is_short(const ordered_json& value) {
  if (!value.is_structured() || value.empty()) return true;
  const auto structured = [](const ordered_json& item) { return item.is_structured(); };
  return value.is_array() && std::none_of(value.begin(), value.end(), structured);
}

void write_block(const ordered_json& value, std::size_t indent, std::string& out);

/// What follows a "key:" or a "-".
void write_inside(const ordered_json& value, std::size_t indent, std::string& out) {
  if (is_short(value)) {
    out.append(" ").append(to_yaml_line(value)).append("\n");
  } else {
    out += "\n";
    write_block(value, indent + 2, out);
  }
}

void write_list_item(const ordered_json& item, std::size_t indent, std::string& out) {
  if (is_short(item)) return write_inside(item, indent, out);
  std::string inner;
  write_block(item, indent + 2, inner);
  out.append(" ").append(inner, indent + 2);  // its first line stands beside the dash
}

void write_block(const ordered_json& value, std::size_t indent, std::string& out) {
  const std::string gap(indent, ' ');
  if (is_short(value)) {
    out += gap + to_yaml_line(value) + "\n";
    return;
  }
  for (const auto& [key, item] : value.items()) {
    out += gap + (value.is_object() ? text_to_yaml(key) + ":" : "-");
    value.is_object() ? write_inside(item, indent, out) : write_list_item(item, indent, out);
  }
}

}  // namespace

void detail::put(ordered_json& object, std::string_view key, ordered_json value) {
  object[std::string(key)] = std::move(value);
}

ordered_json number_to_json(double value) {
  if (std::isnan(value)) return nullptr;
  if (std::isinf(value)) return value > 0.0 ? ".inf" : "-.inf";
  return value;
}

std::string to_yaml(const ordered_json& value) {
  std::string out;
  write_block(value, 0, out);
  return out;
}

std::string to_yaml_line(const ordered_json& value) {
  if (!value.is_structured()) return scalar_to_yaml(value);
  std::string out;
  for (const auto& [key, item] : value.items()) {
    if (!out.empty()) out += ", ";
    out += (value.is_object() ? text_to_yaml(key) + ": " : "") + to_yaml_line(item);
  }
  return value.is_object() ? "{" + out + "}" : "[" + out + "]";
}

}  // namespace bayesctrl
