#include "io/schema.hpp"

#include <algorithm>

namespace bayesctrl::detail {

using nlohmann::ordered_json;

std::string Definitions::name_of(const void* type, std::string_view wanted, bool& fresh) {
  for (const auto& [known, name] : names) {
    if (known == type) return name;
  }
  std::string name(wanted);
  const auto taken = [&] {
    return std::any_of(names.begin(), names.end(), [&](const auto& known) { return known.second == name; });
  };
  for (int number = 2; taken(); ++number) name = std::string(wanted) + std::to_string(number);
  names.emplace_back(type, name);
  fresh = true;
  return name;
}

/// Some readers of YAML give `.inf` as a number, which passes as one without an upper end, others as a text.
ordered_json number_schema(const Range& range, bool whole) {
  ordered_json schema{{"type", whole ? "integer" : "number"}};
  if (range.low != -kInfinity) schema[range.low_open ? "exclusiveMinimum" : "minimum"] = range.low;
  if (range.high != kInfinity) schema[range.high_open ? "exclusiveMaximum" : "maximum"] = range.high;
  if (!range.infinite || whole) return schema;
  return choice_of("anyOf", std::vector<ordered_json>{schema, {{"const", ".inf"}}});
}

ordered_json choice_of(const char* keyword, std::vector<ordered_json> choices) {
  ordered_json list = ordered_json::array();
  for (ordered_json& choice : choices) list.push_back(std::move(choice));
  ordered_json schema;
  schema[keyword] = std::move(list);
  return schema;
}

ordered_json empty_object_schema() {
  ordered_json schema;
  schema["type"] = "object";
  schema["additionalProperties"] = false;
  schema["properties"] = ordered_json::object();
  schema["required"] = ordered_json::array();
  return schema;
}

void annotate(ordered_json& schema, const Info& info) {
  std::string text(info.text);
  if (!info.unit.empty()) text += (text.empty() ? "(" : " (") + std::string(info.unit) + ")";
  if (!text.empty()) schema["description"] = text;
}

void add_property(ordered_json& schema, std::string_view key, ordered_json property, const Info& info,
                  std::optional<ordered_json> fallback) {
  annotate(property, info);
  if (fallback && !info.required) property["default"] = std::move(*fallback);
  schema["properties"][std::string(key)] = std::move(property);
  if (info.required) schema["required"].push_back(key);
}

}  // namespace bayesctrl::detail
