#pragma once

#include <string>

namespace bayesctrl {

/// The shortest decimal text that reads back as the same double; "nan", "inf", "-inf" for the rest.
std::string format(double value);

/// `digits` significant digits, for people.
std::string format(double value, int digits);

}  // namespace bayesctrl
