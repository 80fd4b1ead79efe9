#include "diagnose/recording/unit.hpp"

#include <algorithm>
#include <cctype>
#include <numbers>

namespace bayesctrl {

namespace {

constexpr double kDegree = std::numbers::pi / 180.0, kTurn = 2.0 * std::numbers::pi;
constexpr Unit kUnits[] = {{"rad", 1.0, "rad"},
                           {"mrad", 1e-3, "rad"},
                           {"deg", kDegree, "rad"},
                           {"degree", kDegree, "rad"},
                           {"degrees", kDegree, "rad"},
                           {"rev", kTurn, "rad"},
                           {"turns", kTurn, "rad"},
                           {"m", 1.0, "m"},
                           {"cm", 1e-2, "m"},
                           {"mm", 1e-3, "m"},
                           {"um", 1e-6, "m"},
                           {"rad/s", 1.0, "rad/s"},
                           {"deg/s", kDegree, "rad/s"},
                           {"rpm", kTurn / 60.0, "rad/s"},
                           {"m/s", 1.0, "m/s"},
                           {"mm/s", 1e-3, "m/s"},
                           {"s", 1.0, "s"},
                           {"sec", 1.0, "s"},
                           {"ms", 1e-3, "s"},
                           {"us", 1e-6, "s"},
                           {"ns", 1e-9, "s"},
                           {"min", 60.0, "s"},
                           {"Nm", 1.0, "N m"},
                           {"mNm", 1e-3, "N m"},
                           {"cNm", 1e-2, "N m"},
                           {"Ncm", 1e-2, "N m"},
                           {"Nmm", 1e-3, "N m"},
                           {"kNm", 1e3, "N m"},
                           {"N", 1.0, "N"},
                           {"mN", 1e-3, "N"},
                           {"kN", 1e3, "N"},
                           {"V", 1.0, "V"},
                           {"mV", 1e-3, "V"},
                           {"A", 1.0, "A"},
                           {"mA", 1e-3, "A"},
                           {"degC", 1.0, "degC"},
                           {"celsius", 1.0, "degC"},
                           {"degF", 5.0 / 9.0, "degC", -160.0 / 9.0},
                           {"K", 1.0, "degC", -273.15}};

/// Without blanks and signs of multiplication; the degree sign and the micro sign, in UTF-8 or Latin-1, in letters.
std::string plain(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view rest = text.substr(i);
    const auto sign = [&](std::string_view utf8, std::string_view latin) {
      if (rest.starts_with(utf8)) {
        i += utf8.size() - 1;
        return true;
      }
      return rest.starts_with(latin);
    };
    if (sign("\xC2\xB0", "\xB0")) {
      result += "deg";
    } else if (sign("\xC2\xB5", "\xB5") || sign("\xCE\xBC", "\xB5")) {
      result += 'u';
    } else if (!sign("\xC2\xB7", "\xB7") && !sign("\xE2\x8B\x85", "*") && text[i] != ' ' && text[i] != '.') {
      result += text[i];
    }
  }
  return result;
}

std::string lower(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](unsigned char c) { return std::tolower(c); });
  return result;
}

}  // namespace

const Unit* find_unit(std::string_view text, bool any_case) {
  const std::string wanted = plain(text);
  const auto find = [](auto&& is) {
    const auto found = std::find_if(std::begin(kUnits), std::end(kUnits), is);
    return found == std::end(kUnits) ? nullptr : found;
  };
  if (const Unit* exact = find([&](const Unit& u) { return u.name == wanted; })) return exact;
  return any_case ? find([&](const Unit& u) { return lower(u.name) == lower(wanted); }) : nullptr;
}

std::string known_units() {
  std::string text;
  for (const Unit& unit : kUnits) text += (text.empty() ? "" : ", ") + std::string(unit.name);
  return text;
}

std::string si_unit(std::string_view text) {
  const Unit* unit = find_unit(text);
  return std::string(unit != nullptr ? unit->si : text);
}

}  // namespace bayesctrl
