#include "io/describe.hpp"

namespace bayesctrl::detail {

std::string joined(const std::vector<std::string_view>& words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

}  // namespace bayesctrl::detail
