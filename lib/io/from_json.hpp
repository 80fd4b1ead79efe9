#pragma once

/// The reader of results over the `fields` convention (base/fields.hpp), the inverse of `to_json` (io/emit.hpp). A key
/// that no field declares is passed over: another version may say more. A field that is `required` has to be there,
/// another one keeps its value. What is missing, or of another type, is a DataError that names the file and the key.

#include <concepts>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "base/fields.hpp"

namespace bayesctrl {

namespace detail {

/// A value in a file of results and the way to it.
struct JsonPlace {
  const nlohmann::ordered_json& json;
  const std::string& file;
  std::string path;  // "explanation.effects[0].name"; of the whole ""

  /// Null where there is no such key. Throws DataError if this is no object.
  const nlohmann::ordered_json* find(std::string_view key) const;
  std::string below(std::string_view key) const;
  JsonPlace item(std::size_t index) const;
};

[[noreturn]] void refuse_json(const JsonPlace& place, const std::string& must);
[[noreturn]] void refuse_missing_json(const JsonPlace& place, std::string_view key);
double double_from_json(const JsonPlace& place);  // null is NaN, as number_to_json has it
int int_from_json(const JsonPlace& place);
bool bool_from_json(const JsonPlace& place);
std::string text_from_json(const JsonPlace& place);
std::size_t word_from_json(const JsonPlace& place, const std::vector<std::string_view>& words);
void require_json_list(const JsonPlace& place);
void require_json_object(const JsonPlace& place);

template <class T>
void from_json_at(const JsonPlace& place, T& value);

template <HasFields T>
void fields_from_json(const JsonPlace& place, T& value) {
  require_json_object(place);
  T::fields(value, [&](std::string_view key, auto& member, const Info& info) {
    if (const nlohmann::ordered_json* found = place.find(key)) {
      from_json_at(JsonPlace{*found, place.file, place.below(key)}, member);
    } else if (info.required) {
      refuse_missing_json(place, key);
    }
  });
}

template <class T>
void vector_from_json(const JsonPlace& place, std::vector<T>& value) {
  require_json_list(place);
  value.clear();
  for (std::size_t i = 0; i < place.json.size(); ++i) from_json_at(place.item(i), value.emplace_back());
}

template <class T>
void named_from_json(const JsonPlace& place, Named<T>& value) {
  require_json_object(place);
  value.items.clear();
  for (const auto& [name, item] : place.json.items()) {
    from_json_at(JsonPlace{item, place.file, place.below(name)}, value.items.emplace_back(name, T{}).second);
  }
}

template <class T>
void from_json_at(const JsonPlace& place, T& value) {
  if constexpr (std::same_as<T, double>) {
    value = double_from_json(place);
  } else if constexpr (std::same_as<T, int>) {
    value = int_from_json(place);
  } else if constexpr (std::same_as<T, bool>) {
    value = bool_from_json(place);
  } else if constexpr (std::same_as<T, std::string>) {
    value = text_from_json(place);
  } else if constexpr (NamedEnum<T>) {
    const auto& words = names(T{});
    value = static_cast<T>(word_from_json(place, {std::begin(words), std::end(words)}));
  } else if constexpr (Optional<T>) {
    value.reset();
    if (!place.json.is_null()) from_json_at(place, value.emplace());
  } else if constexpr (Vector<T>) {
    vector_from_json(place, value);
  } else if constexpr (NamedMap<T>) {
    named_from_json(place, value);
  } else {
    static_assert(HasFields<T>, "a type of a field: see base/fields.hpp");
    fields_from_json(place, value);
  }
}

}  // namespace detail

/// `file`: what is named where something is wrong. Throws DataError.
template <class T>
T from_json(const nlohmann::ordered_json& json, const std::string& file) {
  T value{};
  detail::from_json_at(detail::JsonPlace{json, file, ""}, value);
  return value;
}

}  // namespace bayesctrl
