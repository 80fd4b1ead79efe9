#include "io/describe.hpp"

namespace bayesctrl::detail {

std::string joined(const std::vector<std::string_view>& words) {
  std::string text;
  for (const std::string_view word : words) text += (text.empty() ? "" : ", ") + std::string(word);
  return text;
}

void add(std::vector<ParameterDescription>& list, std::string name, const Info& info, std::string range,
         std::string default_value) {
  list.push_back({.name = std::move(name),
                  .unit = std::string(info.unit),
                  .range = std::move(range),
                  .default_value = info.required ? "" : std::move(default_value),
                  .text = std::string(info.text),
                  .required = info.required});
}

}  // namespace bayesctrl::detail
