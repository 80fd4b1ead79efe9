#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace bayesctrl {

/// Text as it may stand in HTML.
std::string escaped(std::string_view text);

/// A page with everything inlined: style, plotting library, the script that draws, and the data that it draws.
std::string page(std::string_view title, const nlohmann::ordered_json& data);

}  // namespace bayesctrl
