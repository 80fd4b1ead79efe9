#include "report/claims_picture.hpp"

#include <vector>

#include "base/format.hpp"
#include "report/read.hpp"

namespace bayesctrl {

namespace {

constexpr double kRow = 24.0, kText = 370.0, kBar = 180.0, kShare = 80.0, kSmall = 110.0, kName = 300.0, kMargin = 10.0;
constexpr double kWidth = 2.0 * kMargin + kText + kBar + kShare + kSmall + kName;

constexpr const char* kStyle =
    "text{font:13px system-ui,sans-serif;fill:#222}.h{font-weight:600}.f{fill:#2a6fb0}.b{fill:#e6e6e6}"
    ".i{stroke:#222;stroke-width:1.5}.l{stroke:#2a6fb0;stroke-width:2;fill:none}.s{fill:#666}"
    "@media(prefers-color-scheme:dark){text{fill:#ddd}.f{fill:#6db3f2}.b{fill:#3a3a3a}.i{stroke:#ddd}.l{stroke:#6db3f2}"
    ".s{fill:#aaa}}";

std::string escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    result += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : std::string(1, c);
  }
  return result;
}

std::string number(double value) { return format(value, 5); }

std::string text_at(double x, double y, const std::string& text, const char* style = nullptr) {
  return "<text x=\"" + number(x) + "\" y=\"" + number(y) + "\"" +
         (style ? std::string(" class=\"") + style + "\"" : "") + ">" + escaped(text) + "</text>\n";
}

std::string box(double x, double y, double width, double height, const char* style) {
  return "<rect x=\"" + number(x) + "\" y=\"" + number(y) + "\" width=\"" + number(width) + "\" height=\"" +
         number(height) + "\" class=\"" + style + "\"/>\n";
}

std::string percent(double share) { return format(100.0 * share, 3) + " %"; }

}  // namespace

std::string claims_picture(const Table& claims, const Table& by_setting) {
  const auto words = [](const Table& table, const char* column) { return texts(table, column, "claims"); };
  const auto figures = [&](const char* column) { return numbers(claims, column, "claims"); };
  const std::vector<std::string> group = words(claims, "group"), claim = words(claims, "claim");
  const std::vector<std::string> setting = words(claims, "setting");
  const std::vector<double> share = figures("share"), low = figures("low"), high = figures("high");
  const std::vector<std::string> bin_claim = words(by_setting, "claim"), bin_setting = words(by_setting, "setting");
  const std::vector<double> bin_share = numbers(by_setting, "share", "claims");

  std::string body;
  double y = kRow;
  const double bar = kMargin + kText, small = bar + kBar + kShare, name = small + kSmall + kMargin;
  body += text_at(bar, y - 6.0, "share of draws in which it holds", "s");
  body += text_at(small, y - 6.0, "over the setting that matters most, lowest to highest", "s");
  for (std::size_t i = 0; i < claim.size(); ++i) {
    if (i == 0 || group[i] != group[i - 1]) {
      y += kRow;
      body += text_at(kMargin, y - 7.0, group[i], "h");
    }
    y += kRow;
    const double top = y - kRow + 4.0, height = kRow - 8.0, middle = top + 0.5 * height;
    body += text_at(kMargin, y - 7.0, claim[i]);
    body += box(bar, top, kBar, height, "b") + box(bar, top, kBar * share[i], height, "f");
    body += "<line x1=\"" + number(bar + kBar * low[i]) + "\" x2=\"" + number(bar + kBar * high[i]) + "\" y1=\"" +
            number(middle) + "\" y2=\"" + number(middle) + "\" class=\"i\"/>\n";
    body += text_at(bar + kBar + 8.0, y - 7.0, percent(share[i]));
    std::vector<double> curve;
    for (std::size_t b = 0; b < bin_claim.size(); ++b) {
      if (bin_claim[b] == claim[i] && bin_setting[b] == setting[i]) curve.push_back(bin_share[b]);
    }
    if (curve.size() < 2) continue;
    std::string points;
    for (std::size_t b = 0; b < curve.size(); ++b) {
      const double x = small + 4.0 + (kSmall - 8.0) * static_cast<double>(b) / static_cast<double>(curve.size() - 1);
      points += (points.empty() ? "" : " ") + number(x) + "," + number(top + height * (1.0 - curve[b]));
    }
    body += box(small, top, kSmall, height, "b") + "<polyline points=\"" + points + "\" class=\"l\"/>\n";
    body += text_at(name, y - 7.0, setting[i], "s");
  }
  return "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " + number(kWidth) + " " + number(y + kMargin) +
         "\" role=\"img\"><title>Share of draws in which each claim holds</title><style>" + kStyle + "</style>\n" +
         body + "</svg>\n";
}

}  // namespace bayesctrl
