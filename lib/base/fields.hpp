#pragma once

/// The `fields` convention: a type that users configure declares each of its parameters once, and the reader, the
/// schema, `bayesctrl list`, provenance and the optimiser all visit that one list.
///
///   struct Pendulum {
///     static constexpr std::string_view kName = "pendulum";
///     static constexpr std::string_view kText = "one plain sentence, shown by `bayesctrl list`";
///     double length = 1.0;
///     static void fields(auto& self, auto&& field) {
///       field("length", self.length, {kPositive, "m", "pivot to centre of mass"});
///     }
///     std::string problem() const;   // optional: a constraint over several fields; empty when all is well
///     static constexpr std::string_view kShort = "length";   // optional: a plain value alone stands for this field
///     Location where;                // optional: set to where the value stands in the user's file
///   };
///
/// Types of a field: double, int, bool, std::uint64_t, std::string, an enum with `names`, std::optional<T>,
/// std::vector<T>, std::map-like `Named<T>`, a type with `fields`, or a std::variant of such types, told apart in YAML
/// by the key `type`.

#include <array>
#include <concepts>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

namespace bayesctrl {

inline constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Admitted values of a number. For a list it holds for each element.
struct Range {
  double low = -kInfinity;
  double high = kInfinity;
  bool low_open = false;  // the end itself is refused
  bool high_open = false;
  bool infinite = false;  // +inf itself is admitted (an infinite length scale: this input does not matter)

  constexpr bool contains(double x) const {
    if (x != x) return false;
    if (x == kInfinity) return infinite;
    return (low_open ? x > low : x >= low) && (high_open ? x < high : x <= high) && x != -kInfinity;
  }
  bool operator==(const Range&) const = default;
};

inline constexpr Range kAny{};
inline constexpr Range kPositive{.low = 0.0, .low_open = true};
inline constexpr Range kPositiveOrInfinite{.low = 0.0, .low_open = true, .infinite = true};
inline constexpr Range kNonNegative{.low = 0.0};
constexpr Range between(double low, double high) { return {.low = low, .high = high}; }

/// "a number greater than 0", "a number from 0.2 to 5": the words of error messages and of `bayesctrl list`.
std::string to_string(const Range& range);

/// What is wrong with values that are each allowed; empty: nothing. `path`: where it is, "controllers.SP1.learner".
struct Problem {
  std::string text;
  std::string path;

  bool empty() const { return text.empty(); }
};

/// In what an amount is given: a plain number, the width of the admitted range, or what recordings measure - the
/// sampling period (s) and its inverse, the longest recording (s) and its inverse, the range of the joint's positions.
enum class Measure { one, admitted, period, rate, duration, per_duration, positions };

struct Amount {
  double times = 0.0;
  Measure of = Measure::one;
};

/// What a search for a parameter takes for granted. The numbers may depend on the other parameters as they stand.
struct SearchInfo {
  double mean = 0.0;    // of the prior
  Amount deviation{};   // of the prior; 0: that of which it does as much as the prior of a torque allows
  Amount step{1e-6};    // of differences, and
  double share = 0.01;  // at least this part of the value
  Amount low{-kInfinity}, high{kInfinity};  // within the admitted range
  double cycle = 0.0;                       // values that differ by this are the same; 0: none are
};

/// What is said of a parameter beside its name and value. Units are SI; "" means dimensionless.
struct Info {
  Range range{};
  std::string_view unit = "";
  std::string_view text = "";
  bool required = false;
  SearchInfo search{};
};
inline constexpr bool kRequired = true;

/// A YAML map from free names to T whose order is kept.
template <class T>
struct Named {
  std::vector<std::pair<std::string, T>> items;

  const T* find(std::string_view name) const {
    for (const auto& [key, value] : items) {
      if (key == name) return &value;
    }
    return nullptr;
  }
  bool operator==(const Named&) const = default;
};

namespace detail {
struct AnyVisitor {
  void operator()(std::string_view, auto&, const Info&) const {}
};
template <class T>
inline constexpr bool is_variant = false;
template <class... T>
inline constexpr bool is_variant<std::variant<T...>> = true;
template <class T>
inline constexpr bool is_optional = false;
template <class T>
inline constexpr bool is_optional<std::optional<T>> = true;
template <class T>
inline constexpr bool is_vector = false;
template <class T>
inline constexpr bool is_vector<std::vector<T>> = true;
template <class T>
inline constexpr bool is_named = false;
template <class T>
inline constexpr bool is_named<Named<T>> = true;
}  // namespace detail

/// A type with the `fields` convention.
template <class T>
concept HasFields = requires(T& t) {
  T::fields(t, detail::AnyVisitor{});
};

/// A type with `fields` of which a plain value alone may be given: `q` for {column: q}.
template <class T>
concept HasShort = HasFields<T> && requires {
  T::kShort;
};

/// A type that wraps a variant as its member `form`, so that a family may contain itself (a sum of kernels).
template <class T>
concept HasForm = requires(T& t) {
  t.form;
}
&&detail::is_variant<decltype(T::form)>;

template <class T>
concept Variant = detail::is_variant<T>;
template <class T>
concept Optional = detail::is_optional<T>;
template <class T>
concept Vector = detail::is_vector<T>;
template <class T>
concept NamedMap = detail::is_named<T>;

/// An enum whose words are given by a constexpr function `names(E)` beside it, in the order of its values from 0.
template <class E>
concept NamedEnum = std::is_enum_v<E> && requires(E e) {
  names(e)[0];
};

template <NamedEnum E>
std::string_view to_name(E value) {
  return names(value)[static_cast<std::size_t>(value)];
}

/// Name of the alternative that a variant holds.
template <class... T>
std::string_view name_of(const std::variant<T...>& variant) {
  return std::visit([](const auto& form) { return std::decay_t<decltype(form)>::kName; }, variant);
}

/// Names of all alternatives, in order of registration.
template <class... T>
std::vector<std::string_view> names_of(const std::variant<T...>*) {
  return {T::kName...};
}

/// Calls f(T{}) for each alternative.
template <class... T>
void for_each_alternative(const std::variant<T...>*, auto&& f) {
  (f(T{}), ...);
}

}  // namespace bayesctrl
