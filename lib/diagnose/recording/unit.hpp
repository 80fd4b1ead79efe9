#pragma once

#include <string>
#include <string_view>

namespace bayesctrl {

/// A unit in which numbers of a recording may be.
struct Unit {
  std::string_view name;  // without blanks
  double scale;           // to SI; degrees Celsius
  std::string_view si;
  double offset = 0.0;  // added after scale
};

/// "N m", "Nm", "N·m" and "mN*m" are known, "deg" and "°" are the same; null for what is none. In
/// headers of files capitals may be anywhere: `any_case`.
const Unit* find_unit(std::string_view text, bool any_case = false);

/// All names, for messages.
std::string known_units();

/// A unit's name in SI; of what is none the text itself.
std::string si_unit(std::string_view text);

}  // namespace bayesctrl
