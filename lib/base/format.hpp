#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace bayesctrl {

/// The shortest decimal text that reads back as the same double; "nan", "inf", "-inf" for the rest.
std::string format(double value);

/// `digits` significant digits, for people.
std::string format(double value, int digits);

/// A number that is at least `digits` digits long, with zeros in front: names that sort as they count.
std::string padded(std::size_t number, std::size_t digits);

/// A probability for people, in percent: never rounded to certainty, "more than 99.9 %".
std::string percent_text(double probability);

/// "100 %", "23 %" or "0.4 %" of a share: two digits, or three of what is nearly all.
std::string share_text(double share);

/// "q" where there is one joint, "q1", "q2", ... where there are several; `index` from 0.
std::string numbered(std::string_view name, std::ptrdiff_t index, std::ptrdiff_t count);

/// "b" or, of several joints, "b12" for an entry of a matrix.
std::string numbered(std::string_view name, std::ptrdiff_t row, std::ptrdiff_t column, std::ptrdiff_t count);

}  // namespace bayesctrl
