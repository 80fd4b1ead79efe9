#pragma once

#include <string>
#include <vector>

#include "base/fields.hpp"
#include "io/emit.hpp"
#include "io/schema.hpp"
#include "io/text.hpp"

namespace bayesctrl {

/// One line of `bayesctrl list`. Parameters inside a plain struct are named with a dot: "sensor.noise".
struct ParameterDescription {
  std::string name;
  std::string unit;
  std::string range;          // "a number greater than 0", "one of the types: a, b"
  std::string default_value;  // as YAML in one line; of a variant its type; empty if required
  std::string text;
  bool required = false;
};

namespace detail {

std::string joined(const std::vector<std::string_view>& words);

void add(std::vector<ParameterDescription>& list, std::string name, const Info& info, std::string range,
         std::string default_value);

/// What `read` accepts for a T, in words.
template <class T>
std::string range_text(const Info& info) {
  if constexpr (HasSchemaValue<T>) {
    Definitions ignored;
    return schema_value(static_cast<const T*>(nullptr), ignored).value("description", "");
  } else if constexpr (std::same_as<T, double>) {
    return to_string(info.range);
  } else if constexpr (std::same_as<T, bool>) {
    return "true or false";
  } else if constexpr (std::integral<T>) {
    return whole_number(admitted<T>(info.range));
  } else if constexpr (std::same_as<T, std::string>) {
    return "a text";
  } else if constexpr (NamedEnum<T>) {
    const auto& words = names(T{});
    return "one of: " + joined({std::begin(words), std::end(words)});
  } else if constexpr (Optional<T>) {
    return range_text<typename T::value_type>(info) + ", or null";
  } else if constexpr (Vector<T>) {
    return "a list, each " + range_text<typename T::value_type>(info);
  } else if constexpr (NamedMap<T>) {
    return "a map of free names, each " + range_text<std::decay_t<decltype(T{}.items.front().second)>>(info);
  } else if constexpr (Variant<T>) {
    return "one of the types: " + joined(names_of(static_cast<const T*>(nullptr)));
  } else if constexpr (HasForm<T>) {
    return "one of the types: " + joined(names_of(static_cast<const decltype(T::form)*>(nullptr)));
  } else if constexpr (HasShort<T>) {
    return "a map, or its " + std::string(T::kShort) + " alone";
  } else {
    return "a map";
  }
}

template <class T>
std::string default_text(const T& value) {
  if constexpr (Variant<T>)
    return std::string(name_of(value));
  else if constexpr (HasForm<T>)
    return std::string(name_of(value.form));
  else
    return to_yaml_line(to_json(value));
}

template <HasFields T>
void describe_fields(const T& defaults, const std::string& prefix, std::vector<ParameterDescription>& list) {
  T::fields(defaults, [&]<class Member>(std::string_view key, const Member& member, const Info& info) {
    const std::string name = prefix + std::string(key);
    if constexpr (HasFields<Member> && !HasJsonValue<Member>) {
      describe_fields(Member{}, name + ".", list);
    } else {
      add(list, name, info, range_text<Member>(info), default_text(member));
    }
  });
}

}  // namespace detail

/// The parameters of T in the order of their declaration.
template <HasFields T>
std::vector<ParameterDescription> describe(const T& defaults = {}) {
  std::vector<ParameterDescription> list;
  detail::describe_fields(defaults, "", list);
  return list;
}

}  // namespace bayesctrl
