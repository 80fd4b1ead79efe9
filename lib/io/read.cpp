#include "io/read.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "io/text.hpp"

namespace bayesctrl::detail {

namespace {

std::string with_unit(std::string_view unit) { return unit.empty() ? "" : " (" + std::string(unit) + ")"; }

bool is_plain(const Node& node) { return node.kind == Node::Kind::scalar && !node.quoted; }

std::string list_of(const Names& words) {
  std::string text = "allowed:";
  for (const std::string_view word : words) text += (text.back() == ':' ? " " : ", ") + std::string(word);
  return text;
}

/// Why a scalar that looks like a number is refused, for those who meant one.
std::string number_hint(const Node& node) {
  if (node.kind != Node::Kind::scalar) return "";
  if (node.quoted) return ": in quotes it is a text";
  if (node.text == ".inf" || node.text == "-.inf") return ": " + node.text + " is not admitted here";
  if (is_decimal(node.text)) return "";
  const std::size_t first = std::min(node.text.find_first_not_of("+-."), node.text.size());
  const bool digits = first < node.text.size() && node.text[first] >= '0' && node.text[first] <= '9';
  return digits ? ": written in decimal without leading zeros, such as 10, -0.5 or 1e-3" : "";
}

/// Empty when the text is no decimal number. Infinity also in quotes: JSON has it so.
std::optional<double> double_of(const Node& node) {
  if (node.kind == Node::Kind::scalar && node.text == ".inf") return kInfinity;
  return is_plain(node) ? parse_double(node.text) : std::nullopt;
}

template <class T>
T to_integer(const Node& node, std::string_view name, const Info& info) {
  const Range range = admitted<T>(info.range);
  const std::optional<T> value = is_plain(node) ? parse_integer<T>(node.text) : std::nullopt;
  if (value && range.contains(static_cast<double>(*value))) return *value;
  const bool too_large = !value && is_plain(node) && is_whole(node.text) && !node.text.starts_with('-');
  const std::string limit = std::to_string(std::numeric_limits<T>::max());
  refuse(node, name, whole_number(range) + with_unit(info.unit), too_large ? ", at most " + limit : number_hint(node));
}

}  // namespace

void refuse(const Node& node, std::string_view name, const std::string& must, const std::string& hint) {
  const std::string mark = node.quoted ? "\"" : "";
  std::string given = std::string(shown(name));
  switch (node.kind) {
    case Node::Kind::null:
      given += " has no value";
      break;
    case Node::Kind::scalar:
      given += " = " + mark + shown(node.text) + mark;
      break;
    case Node::Kind::sequence:
      given += " is a list";
      break;
    case Node::Kind::map:
      given += " is a map";
      break;
  }
  throw SpecError(node.where, given + ", must be " + must + hint);
}

double to_double(const Node& node, std::string_view name, const Info& info) {
  const std::optional<double> value = double_of(node);
  if (value && info.range.contains(*value)) return *value;
  const bool beyond = !value && is_plain(node) && is_decimal(node.text);
  refuse(node, name, to_string(info.range) + with_unit(info.unit),
         beyond ? ": beyond what 64 bits can hold" : number_hint(node));
}

int to_int(const Node& node, std::string_view name, const Info& info) { return to_integer<int>(node, name, info); }

std::uint64_t to_uint64(const Node& node, std::string_view name, const Info& info) {
  return to_integer<std::uint64_t>(node, name, info);
}

bool to_bool(const Node& node, std::string_view name) {
  if (is_plain(node) && (node.text == "true" || node.text == "false")) return node.text == "true";
  refuse(node, name, "true or false");
}

std::string to_text(const Node& node, std::string_view name) {
  if (node.kind == Node::Kind::scalar) return node.text;
  refuse(node, name, "a text");
}

std::size_t to_word(const Node& node, std::string_view name, const Names& words) {
  if (node.kind != Node::Kind::scalar) refuse(node, name, "a word", ", " + list_of(words));
  const auto found = std::find(words.begin(), words.end(), node.text);
  if (found != words.end()) return static_cast<std::size_t>(found - words.begin());
  throw SpecError(node.where, std::string(name) + " = '" + shown(node.text) + "', " + suggestion(node.text, words));
}

std::size_t to_alternative(const Node& node, std::string_view name, const Names& types) {
  if (node.kind != Node::Kind::map) refuse(node, name, "a map with the key 'type'", ", " + list_of(types));
  const Node::Entry* type = node.find("type");
  if (type == nullptr) throw SpecError(node.where, std::string(name) + " needs 'type', " + list_of(types));
  return to_word(type->value, "type", types);
}

Node as_map(const Node& node, std::string_view key) {
  Node map;
  map.kind = Node::Kind::map;
  map.where = node.where;
  map.entries.push_back({std::string(key), node.where, node});
  return map;
}

void require_list(const Node& node, std::string_view name) {
  if (node.kind != Node::Kind::sequence) refuse(node, name, "a list");
}

void require_map(const Node& node, std::string_view name) {
  if (node.kind != Node::Kind::map) refuse(node, name, "a map");
}

void require_known_keys(const Node& map, std::string_view owner, const Names& known) {
  for (const Node::Entry& entry : map.entries) {
    if (std::find(known.begin(), known.end(), entry.key) != known.end()) continue;
    const std::string advice = known.empty() ? "it has no parameters" : suggestion(entry.key, known);
    throw SpecError(entry.where, shown(owner) + " has no '" + shown(entry.key) + "', " + advice);
  }
}

void refuse_override_of_nothing(const Node& map, std::string_view name, const Node::Entry& entry) {
  const bool from_file = entry.where.line > 0;
  if (from_file || entry.value.kind != Node::Kind::map || entry.value.find("type") != nullptr) return;
  Names others;
  for (const Node::Entry& other : map.entries) {
    if (&other != &entry) others.push_back(other.key);
  }
  throw SpecError(entry.where, std::string(name) + " has no '" + entry.key + "', " + suggestion(entry.key, others));
}

void require_names(const Node& map, std::string_view name) {
  for (const Node::Entry& entry : map.entries) {
    if (entry.key.empty()) throw SpecError(entry.where, "a name in " + shown(name) + " is empty");
  }
}

void refuse_missing(const Node& map, std::string_view owner, std::string_view key, const Info& info) {
  const std::string text = info.text.empty() ? "" : ": " + std::string(info.text);
  throw SpecError(map.where, shown(owner) + " needs '" + std::string(key) + "'" + text + with_unit(info.unit));
}

std::string indexed(std::string_view name, std::size_t index) {
  return std::string(name) + "[" + std::to_string(index) + "]";
}

}  // namespace bayesctrl::detail
