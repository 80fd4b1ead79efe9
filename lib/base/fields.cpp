#include "base/fields.hpp"

#include "base/format.hpp"

namespace bayesctrl {

std::string to_string(const Range& range) {
  const bool low = range.low != -kInfinity;
  const bool high = range.high != kInfinity;
  std::string text = "a number";
  if (low && high && !range.low_open && !range.high_open) {
    text += " from " + format(range.low) + " to " + format(range.high);
  } else {
    if (low) text += (range.low_open ? " greater than " : " of at least ") + format(range.low);
    if (low && high) text += " and";
    if (high) text += (range.high_open ? " less than " : " of at most ") + format(range.high);
  }
  if (range.infinite) text += " or .inf";
  return text;
}

}  // namespace bayesctrl
