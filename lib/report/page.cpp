#include "report/page.hpp"

#include "io/provenance.hpp"
#include "report_assets.hpp"

namespace bayesctrl {

namespace {

/// JSON that cannot end the element in which it stands.
std::string harmless(const nlohmann::ordered_json& data) {
  std::string text = data.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  std::string result;
  for (const char c : text) {
    if (c == '<') {
      result += "\\u003c";
    } else {
      result += c;
    }
  }
  return result;
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

std::string page(std::string_view title, std::string_view script, const nlohmann::ordered_json& data) {
  std::string html =
      "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<link rel=\"icon\" href=\"data:,\">\n<title>";
  html += escaped(title);
  html += "</title>\n<style>\n";
  html += assets::k_uPlot_min_css;
  html += assets::k_report_css;
  html += "</style>\n</head>\n<body>\n<header><h1>";
  html += escaped(title);
  html +=
      "</h1></header>\n<main></main>\n<noscript><p>This page draws itself: allow "
      "JavaScript, or read the tables in the folder beside it.</p></noscript>\n<footer>\n<p>Written by bayesctrl ";
  html += escaped(program_version()) + " (" + escaped(program_revision()) +
          ").</p>\n<details><summary>Plots: uPlot, MIT licence</summary><pre>";
  html += escaped(assets::k_LICENSE);
  html += "</pre></details>\n</footer>\n<script type=\"application/json\" id=\"data\">";
  html += harmless(data);
  html += "</script>\n<script>\n";
  html += assets::k_uPlot_iife_min_js;
  html += "\n</script>\n<script>\n\"use strict\";\n(() => {\n";
  for (const std::string_view part : {assets::k_common_js, assets::k_plot_js, assets::k_picture_js, script})
    html += part;
  html += "})();\n</script>\n</body>\n</html>\n";
  return html;
}

}  // namespace bayesctrl
