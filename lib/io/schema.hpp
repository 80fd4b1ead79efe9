#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/fields.hpp"
#include "io/emit.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace detail {

template <class T>
inline constexpr char identity = 0;  // its address tells types apart

/// What is referred to from several places, or contains itself, is defined once, under `$defs`.
struct Definitions {
  std::vector<std::pair<const void*, std::string>> names;  // identity of the type, its name under `$defs`
  nlohmann::ordered_json schemas = nlohmann::ordered_json::object();

  /// Name of the type's definition; `fresh` tells that it is yet to be written.
  std::string name_of(const void* type, std::string_view wanted, bool& fresh);

  /// A reference to the definition of T, made by `make()` when it is asked for first.
  template <class T>
  nlohmann::ordered_json once(std::string_view wanted, auto&& make) {
    bool fresh = false;
    const std::string name = name_of(&identity<T>, wanted, fresh);
    if (fresh) schemas[name] = make();
    return {{"$ref", "#/$defs/" + name}};
  }
};

}  // namespace detail

template <class T>
concept HasSchemaValue = requires(const T* type, detail::Definitions& definitions) {
  nlohmann::ordered_json(schema_value(type, definitions));
};

namespace detail {

nlohmann::ordered_json number_schema(const Range& range, bool whole);
nlohmann::ordered_json choice_of(const char* keyword, std::vector<nlohmann::ordered_json> choices);
nlohmann::ordered_json empty_object_schema();

/// Adds text and unit to the schema of one parameter.
void annotate(nlohmann::ordered_json& schema, const Info& info);

/// Adds one parameter, with its text, unit and default, to the schema of an object.
void add_property(nlohmann::ordered_json& schema, std::string_view key, nlohmann::ordered_json property,
                  const Info& info, std::optional<nlohmann::ordered_json> fallback);

template <class T>
nlohmann::ordered_json schema_of(std::string_view key, const Info& info, Definitions& definitions);

template <class T>
inline constexpr bool has_plain_default = !(HasFields<T> || HasForm<T> || Variant<T> || Vector<T> || NamedMap<T>);
template <>
inline constexpr bool has_plain_default<std::vector<double>> = true;

template <HasFields T>
nlohmann::ordered_json object_schema(const T& defaults, Definitions& definitions, std::string_view type,
                                     std::string_view text) {
  nlohmann::ordered_json schema = empty_object_schema();
  if (!type.empty()) {
    schema["properties"]["type"] = {{"const", type}};
    schema["required"].push_back("type");
  }
  if (!text.empty()) schema["description"] = text;
  T::fields(defaults, [&]<class Member>(std::string_view key, const Member& member, const Info& info) {
    std::optional<nlohmann::ordered_json> fallback;
    if constexpr (has_plain_default<Member>) fallback = to_json(member);
    add_property(schema, key, schema_of<Member>(key, info, definitions), info, std::move(fallback));
  });
  return schema;
}

template <HasFields T>
nlohmann::ordered_json object_schema(Definitions& definitions, std::string_view type = "") {
  std::string_view text;
  if constexpr (requires { T::kText; }) text = T::kText;
  return object_schema(T{}, definitions, type, text);
}

/// Either all fields, or a plain value for the one that may stand alone.
template <HasShort T>
nlohmann::ordered_json short_schema(Definitions& definitions) {
  const nlohmann::ordered_json whole = object_schema<T>(definitions);
  nlohmann::ordered_json alone = whole["properties"][std::string(T::kShort)];
  alone.erase("description");
  return choice_of("anyOf", std::vector<nlohmann::ordered_json>{alone, whole});
}

template <class... T>
nlohmann::ordered_json variant_schema(const std::variant<T...>*, Definitions& definitions) {
  return choice_of("oneOf", std::vector<nlohmann::ordered_json>{object_schema<T>(definitions, T::kName)...});
}

template <HasForm T>
nlohmann::ordered_json form_schema(std::string_view key, Definitions& definitions) {
  std::string_view wanted = key;
  if constexpr (requires { T::kName; }) wanted = T::kName;
  return definitions.once<T>(
      wanted, [&] { return variant_schema(static_cast<const decltype(T::form)*>(nullptr), definitions); });
}

template <class T>
nlohmann::ordered_json schema_of(std::string_view key, const Info& info, Definitions& definitions) {
  using nlohmann::ordered_json;
  if constexpr (HasSchemaValue<T>) {
    return schema_value(static_cast<const T*>(nullptr), definitions);
  } else if constexpr (std::same_as<T, double>) {
    return number_schema(info.range, false);
  } else if constexpr (std::same_as<T, bool>) {
    return {{"type", "boolean"}};
  } else if constexpr (std::integral<T>) {
    return number_schema(admitted<T>(info.range), true);
  } else if constexpr (std::same_as<T, std::string>) {
    return {{"type", {"string", "number", "boolean"}}};
  } else if constexpr (NamedEnum<T>) {
    return {{"enum", names(T{})}};
  } else if constexpr (Optional<T>) {
    const ordered_json value = schema_of<typename T::value_type>(key, info, definitions);
    return choice_of("anyOf", std::vector<ordered_json>{value, {{"type", "null"}}});
  } else if constexpr (Vector<T>) {
    const ordered_json item = schema_of<typename T::value_type>(key, info, definitions);
    const ordered_json list{{"type", "array"}, {"items", item}};
    constexpr bool kOneMayStandAlone = std::same_as<T, std::vector<double>> || HasFields<typename T::value_type>;
    return kOneMayStandAlone ? choice_of("anyOf", std::vector<ordered_json>{list, item}) : list;
  } else if constexpr (NamedMap<T>) {
    using Item = std::decay_t<decltype(T{}.items.front().second)>;
    return {{"type", "object"},
            {"propertyNames", {{"minLength", 1}}},
            {"additionalProperties", schema_of<Item>(key, info, definitions)}};
  } else if constexpr (Variant<T>) {
    return variant_schema(static_cast<const T*>(nullptr), definitions);
  } else if constexpr (HasForm<T>) {
    return form_schema<T>(key, definitions);
  } else if constexpr (HasShort<T>) {
    return short_schema<T>(definitions);
  } else {
    static_assert(HasFields<T>, "a type of a field: see base/fields.hpp");
    return object_schema<T>(definitions);
  }
}

}  // namespace detail

/// JSON Schema (draft 2020-12; the keywords used mean the same in draft 7 with `$defs` resolved as a plain pointer) of
/// the YAML that `read<T>` accepts. `problem()` is not in it: constraints over several fields.
template <class T>
nlohmann::ordered_json schema() {
  detail::Definitions definitions;
  nlohmann::ordered_json result{{"$schema", "https://json-schema.org/draft/2020-12/schema"}};
  result.update(detail::schema_of<T>("root", Info{}, definitions));
  if (!definitions.schemas.empty()) result["$defs"] = std::move(definitions.schemas);
  return result;
}

}  // namespace bayesctrl
