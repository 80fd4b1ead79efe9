#pragma once

/// The strict reader over the `fields` convention (base/fields.hpp): from a Node to a value, or a SpecError that says
/// where, what, and what is allowed. A type that needs a notation of its own gives, in namespace bayesctrl and before
/// its first use, `void read_value(const Node&, T&)`, `nlohmann::ordered_json json_value(const T&)` (io/emit.hpp) and
/// `nlohmann::ordered_json schema_value(const T*, detail::Definitions&)` (io/schema.hpp); these then take precedence.

#include <concepts>
#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/fields.hpp"
#include "io/node.hpp"

namespace bayesctrl {

template <class T>
concept HasReadValue = requires(const Node& node, T& value) {
  read_value(node, value);
};

namespace detail {

using Names = std::vector<std::string_view>;

/// Throws SpecError "name = given, must be `must``hint`", at the node.
[[noreturn]] void refuse(const Node& node, std::string_view name, const std::string& must,
                         const std::string& hint = "");

double to_double(const Node& node, std::string_view name, const Info& info);
int to_int(const Node& node, std::string_view name, const Info& info);
std::uint64_t to_uint64(const Node& node, std::string_view name, const Info& info);
bool to_bool(const Node& node, std::string_view name);
std::string to_text(const Node& node, std::string_view name);

/// Index of the word in `words`.
std::size_t to_word(const Node& node, std::string_view name, const Names& words);

/// Index in `types` of the map's key `type`.
std::size_t to_alternative(const Node& node, std::string_view name, const Names& types);

/// {key: node}, at the node's place.
Node as_map(const Node& node, std::string_view key);

void require_list(const Node& node, std::string_view name);
void require_map(const Node& node, std::string_view name);
void require_known_keys(const Node& map, std::string_view owner, const Names& known);
void require_names(const Node& map, std::string_view name);

/// Refuses an entry that `--set` made on its way to a setting of something that is not there, a mistyped name.
void refuse_override_of_nothing(const Node& map, std::string_view name, const Node::Entry& entry);
[[noreturn]] void refuse_missing(const Node& map, std::string_view owner, std::string_view key, const Info& info);
std::string indexed(std::string_view name, std::size_t index);

template <class T>
std::string_view owner_name(std::string_view key) {
  if constexpr (requires { T::kName; }) return T::kName;
  return key;
}

/// Where the deepest part of a path stands that is there.
inline Location place_of(const Node& node, std::string_view path) {
  const Node::Entry* entry = path.empty() ? nullptr : node.find(path.substr(0, path.find('.')));
  if (entry == nullptr) return node.where;
  const std::size_t dot = path.find('.');
  return dot == std::string_view::npos ? entry->value.where : place_of(entry->value, path.substr(dot + 1));
}

template <class T>
void require_no_problem(const Node& node, const T& value) {
  if constexpr (requires { std::string(value.problem()); }) {
    if (const std::string problem = value.problem(); !problem.empty()) throw SpecError(node.where, problem);
  } else if constexpr (requires { value.problem().path; }) {
    if (const Problem problem = value.problem(); !problem.empty()) {
      throw SpecError(place_of(node, problem.path), problem.text);
    }
  }
}

template <class T>
void read_node(const Node& node, std::string_view name, const Info& info, T& value);

/// `known` are the keys beside the declared ones.
template <HasFields T>
void read_fields(const Node& node, std::string_view name, T& value, Names known = {}) {
  if constexpr (requires { value.where = node.where; }) value.where = node.where;
  if constexpr (HasShort<T>) {
    if (node.kind == Node::Kind::scalar) return read_fields(as_map(node, T::kShort), name, value, known);
  }
  require_map(node, name);
  const std::string_view owner = owner_name<T>(name);
  T::fields(value, [&](std::string_view key, auto&, const Info&) { known.push_back(key); });
  require_known_keys(node, owner, known);
  T::fields(value, [&](std::string_view key, auto& member, const Info& info) {
    if (const Node::Entry* entry = node.find(key)) {
      read_node(entry->value, key, info, member);
    } else if (info.required) {
      refuse_missing(node, owner, key, info);
    }
  });
  require_no_problem(node, value);
}

template <class... T>
void read_variant(const Node& node, std::string_view name, std::variant<T...>& value) {
  const std::size_t chosen = to_alternative(node, name, {T::kName...});
  std::size_t index = 0;
  const auto read_if_chosen = [&]<class Form>() {
    if (index++ == chosen) read_fields(node, name, value.template emplace<Form>(), {"type"});
  };
  (read_if_chosen.template operator()<T>(), ...);
}

template <class T>
void read_vector(const Node& node, std::string_view name, const Info& info, std::vector<T>& value) {
  value.clear();
  if constexpr (std::same_as<T, double>) {  // one joint: a number is a list of one
    if (node.kind == Node::Kind::scalar) return value.push_back(to_double(node, name, info));
  }
  if constexpr (HasFields<T>) {  // the same process for every joint: a map is a list of one
    const bool one = node.kind == Node::Kind::map || (HasShort<T> && node.kind == Node::Kind::scalar);
    if (one) return read_node(node, name, info, value.emplace_back());
  }
  require_list(node, name);
  value.reserve(node.items.size());
  for (const Node& item : node.items) {
    const std::string item_name = indexed(name, value.size());
    read_node(item, item_name, info, value.emplace_back());
  }
}

template <class T>
void read_named(const Node& node, std::string_view name, const Info& info, Named<T>& value) {
  require_map(node, name);
  require_names(node, name);
  value.items.clear();
  value.items.reserve(node.entries.size());
  for (const Node::Entry& entry : node.entries) {
    if constexpr (Variant<T>) refuse_override_of_nothing(node, name, entry);
    read_node(entry.value, entry.key, info, value.items.emplace_back(entry.key, T{}).second);
  }
}

template <class T>
void read_optional(const Node& node, std::string_view name, const Info& info, std::optional<T>& value) {
  if (node.kind == Node::Kind::null) return value.reset();
  read_node(node, name, info, value.emplace());
}

template <class T>
void read_node(const Node& node, std::string_view name, const Info& info, T& value) {
  if constexpr (HasReadValue<T>) {
    read_value(node, value);
  } else if constexpr (std::same_as<T, double>) {
    value = to_double(node, name, info);
  } else if constexpr (std::same_as<T, int>) {
    value = to_int(node, name, info);
  } else if constexpr (std::same_as<T, std::uint64_t>) {
    value = to_uint64(node, name, info);
  } else if constexpr (std::same_as<T, bool>) {
    value = to_bool(node, name);
  } else if constexpr (std::same_as<T, std::string>) {
    value = to_text(node, name);
  } else if constexpr (NamedEnum<T>) {
    const auto& words = names(T{});
    value = static_cast<T>(to_word(node, name, Names(std::begin(words), std::end(words))));
  } else if constexpr (Optional<T>) {
    read_optional(node, name, info, value);
  } else if constexpr (Vector<T>) {
    read_vector(node, name, info, value);
  } else if constexpr (NamedMap<T>) {
    read_named(node, name, info, value);
  } else if constexpr (Variant<T>) {
    read_variant(node, name, value);
  } else if constexpr (HasForm<T>) {
    read_variant(node, name, value.form);
    require_no_problem(node, value);
  } else {
    static_assert(HasFields<T>, "a type of a field: see base/fields.hpp");
    read_fields(node, name, value);
  }
}

}  // namespace detail

/// What the node gives replaces what `value` has; the rest stays. After a SpecError `value` may be half replaced.
template <class T>
void read_into(const Node& node, T& value) {
  detail::read_node(node, "the spec", Info{}, value);
}

template <class T>
T read(const Node& node) {
  T value{};
  read_into(node, value);
  return value;
}

}  // namespace bayesctrl
