#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace bayesctrl::testing {

inline int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// The data that a page draws.
inline nlohmann::ordered_json data_of(const std::string& html) {
  const std::string begin = "id=\"data\">";
  const std::size_t from = html.find(begin) + begin.size();
  return nlohmann::ordered_json::parse(html.substr(from, html.find("</script>", from) - from));
}

}  // namespace bayesctrl::testing
