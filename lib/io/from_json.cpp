#include "io/from_json.hpp"

#include <algorithm>
#include <limits>

#include "base/error.hpp"

namespace bayesctrl::detail {

using nlohmann::ordered_json;

namespace {

constexpr std::size_t kShownValue = 40;  // bytes of a value in a message

/// The value in one line, as a message shows it.
std::string shown_value(const ordered_json& json) {
  const std::string text = json.dump(-1, ' ', true, ordered_json::error_handler_t::replace);
  return text.size() > kShownValue ? text.substr(0, kShownValue) + "..." : text;
}

constexpr const char* kDamaged = " (damaged or of another version)";

}  // namespace

const ordered_json* JsonPlace::find(std::string_view key) const {
  const auto found = json.find(std::string(key));
  return found == json.end() ? nullptr : &*found;
}

std::string JsonPlace::below(std::string_view key) const {
  return path.empty() ? std::string(key) : path + "." + std::string(key);
}

JsonPlace JsonPlace::item(std::size_t index) const {
  return {json[index], file, path + "[" + std::to_string(index) + "]"};
}

void refuse_json(const JsonPlace& place, const std::string& must) {
  const std::string name = place.path.empty() ? "the whole" : place.path;
  throw DataError(Location{place.file}, name + " = " + shown_value(place.json) + ", must be " + must + kDamaged);
}

void refuse_missing_json(const JsonPlace& place, std::string_view key) {
  throw DataError(Location{place.file}, "lacks the key '" + place.below(key) + "'" + kDamaged);
}

double double_from_json(const JsonPlace& place) {
  if (place.json.is_null()) return std::numeric_limits<double>::quiet_NaN();
  if (place.json == ".inf") return kInfinity;
  if (place.json == "-.inf") return -kInfinity;
  if (!place.json.is_number()) refuse_json(place, "a number");
  return place.json.get<double>();
}

int int_from_json(const JsonPlace& place) {
  constexpr auto kLow = std::numeric_limits<int>::min(), kHigh = std::numeric_limits<int>::max();
  if (!place.json.is_number_integer()) refuse_json(place, "a whole number");
  const double value = place.json.get<double>();
  if (!(value >= kLow && value <= kHigh)) refuse_json(place, "a whole number that an int holds");
  return place.json.get<int>();
}

bool bool_from_json(const JsonPlace& place) {
  if (!place.json.is_boolean()) refuse_json(place, "true or false");
  return place.json.get<bool>();
}

std::string text_from_json(const JsonPlace& place) {
  if (!place.json.is_string()) refuse_json(place, "a text");
  return place.json.get<std::string>();
}

std::size_t word_from_json(const JsonPlace& place, const std::vector<std::string_view>& words) {
  std::string allowed;
  for (const std::string_view word : words) allowed += (allowed.empty() ? "" : ", ") + std::string(word);
  if (!place.json.is_string()) refuse_json(place, "one of " + allowed);
  const auto found = std::find(words.begin(), words.end(), place.json.get_ref<const std::string&>());
  if (found == words.end()) refuse_json(place, "one of " + allowed);
  return static_cast<std::size_t>(found - words.begin());
}

void require_json_list(const JsonPlace& place) {
  if (!place.json.is_array()) refuse_json(place, "a list");
}

void require_json_object(const JsonPlace& place) {
  if (!place.json.is_object()) refuse_json(place, "an object");
}

}  // namespace bayesctrl::detail
