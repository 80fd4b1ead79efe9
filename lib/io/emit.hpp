#pragma once

#include <cmath>
#include <concepts>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <variant>

#include "base/fields.hpp"

namespace bayesctrl {

template <class T>
concept HasJsonValue = requires(const T& value) {
  nlohmann::ordered_json(json_value(value));
};

/// JSON has no infinities: they are the texts ".inf" and "-.inf", and NaN is null.
nlohmann::ordered_json number_to_json(double value);

/// The resolved value with every default, in the order of declaration; a variant has `type` first.
template <class T>
nlohmann::ordered_json to_json(const T& value);

namespace detail {

void put(nlohmann::ordered_json& object, std::string_view key, nlohmann::ordered_json value);

template <HasFields T>
void fields_to_json(const T& value, nlohmann::ordered_json& object) {
  T::fields(value, [&](std::string_view key, const auto& member, const Info&) {
    put(object, key, bayesctrl::to_json(member));
  });
}

template <class... T>
nlohmann::ordered_json variant_to_json(const std::variant<T...>& value) {
  nlohmann::ordered_json object{{"type", name_of(value)}};
  std::visit([&](const auto& form) { fields_to_json(form, object); }, value);
  return object;
}

}  // namespace detail

template <class T>
nlohmann::ordered_json to_json(const T& value) {
  using nlohmann::ordered_json;
  if constexpr (HasJsonValue<T>) {
    return json_value(value);
  } else if constexpr (std::same_as<T, double>) {
    return number_to_json(value);
  } else if constexpr (std::integral<T> || std::same_as<T, std::string>) {
    return ordered_json(value);
  } else if constexpr (NamedEnum<T>) {
    return ordered_json(to_name(value));
  } else if constexpr (Optional<T>) {
    return value ? to_json(*value) : ordered_json(nullptr);
  } else if constexpr (Vector<T>) {
    ordered_json list = ordered_json::array();
    for (const auto& item : value) list.push_back(to_json(item));
    return list;
  } else if constexpr (NamedMap<T>) {
    ordered_json object = ordered_json::object();
    for (const auto& [name, item] : value.items) object[name] = to_json(item);
    return object;
  } else if constexpr (Variant<T>) {
    return detail::variant_to_json(value);
  } else if constexpr (HasForm<T>) {
    return detail::variant_to_json(value.form);
  } else {
    static_assert(HasFields<T>, "a type of a field: see base/fields.hpp");
    ordered_json object = ordered_json::object();
    detail::fields_to_json(value, object);
    return object;
  }
}

/// YAML text that `parse_yaml` reads back to the same value, and so do readers of YAML 1.1. Maps and lists stand in
/// block style, lists of plain values in one line; numbers are the shortest that round-trip. Texts must be UTF-8.
std::string to_yaml(const nlohmann::ordered_json& value);

/// The same in one line: "[1, 2.5]", "{type: sum, terms: []}".
std::string to_yaml_line(const nlohmann::ordered_json& value);

}  // namespace bayesctrl
