#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

namespace bayesctrl {

/// Text as it may stand in HTML.
std::string escaped(std::string_view text);

/// A page with everything inlined: style, plotting library, the data, and the scripts that draw them: what all pages
/// share, and `script`, which draws this kind. A content security policy forbids every request.
std::string page(std::string_view title, std::string_view script, const nlohmann::ordered_json& data);

}  // namespace bayesctrl
