#include <algorithm>
#include <array>
#include <map>

#include "report/page.hpp"
#include "report/pages.hpp"
#include "report/read.hpp"
#include "report_assets.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kBins = 10;  // of stated probabilities

}  // namespace

std::string trial_page(const fs::path& folder) {
  const ordered_json summary = read_json(folder / "summary.json");
  const Table cases = read_csv(folder / "cases.csv");
  const std::string file = (folder / "cases.csv").string();
  const std::vector<double> named = numbers(cases, "named", file), probability = numbers(cases, "probability", file);
  const std::vector<std::string> families = texts(cases, "family", file), verdicts = texts(cases, "verdict", file),
                                 truths = texts(cases, "truth", file);
  struct Row {
    int cases = 0, said = 0, declined = 0;
  };
  std::map<std::string, Row> rows;
  std::array<std::array<double, 3>, kBins> bins{};  // cases, stated, right
  for (std::size_t i = 0; i < cases.rows(); ++i) {
    const std::string &family = families[i], &verdict = verdicts[i];
    if (family == "pysindy") continue;
    const bool nothing = family == "nothing";
    const bool right = nothing ? verdict == "nothing_missing" : named[i] > 0.5;
    Row& row = rows[(family == "outside" ? "outside: " : "") + truths[i]];
    ++row.cases;
    row.said += right;
    row.declined += verdict == "unknown";
    if (verdict != "named" && verdict != "ambiguous") continue;
    auto& bin = bins[static_cast<std::size_t>(std::clamp(static_cast<int>(probability[i] * kBins), 0, kBins - 1))];
    bin[0] += 1.0;
    bin[1] += probability[i];
    bin[2] += right;
  }
  ordered_json confusion = ordered_json::array(), calibration = ordered_json::array();
  for (const auto& [name, row] : rows) {
    confusion.push_back({name, row.cases, row.said, row.cases - row.said - row.declined, row.declined});
  }
  for (const auto& bin : bins) {
    if (bin[0] > 0.0)
      calibration.push_back({{"stated", bin[1] / bin[0]}, {"right", bin[2] / bin[0]}, {"cases", bin[0]}});
  }
  const std::string seed = summary.contains("seed") ? summary.at("seed").dump() : "?";
  return page(
      "Trial on concealed effects, seed " + seed, assets::k_trial_js,
      {{"sentence", std::to_string(cases.rows()) + " machines with concealed physics, or none, were diagnosed from "
                                                   "their recordings alone; then the truth was opened."},
       {"summary", summary},
       {"confusion", confusion},
       {"calibration", calibration}});
}

}  // namespace bayesctrl
