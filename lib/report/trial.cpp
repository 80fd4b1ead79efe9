#include <algorithm>
#include <array>
#include <map>

#include "base/error.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "report/page.hpp"
#include "report/pages.hpp"
#include "report/read.hpp"
#include "report_assets.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

constexpr int kBins = 10;  // of stated probabilities

/// Where an answer stands in the matrix of hidden effects and answers.
std::string answer(Verdict verdict, const std::string& said) {
  if (verdict == Verdict::nothing_missing) return "nothing";
  if (verdict == Verdict::unknown) return "declined";
  if (verdict == Verdict::too_little_data) return "too little data";
  if (verdict == Verdict::check_spec) return "check the spec";
  return said.find(" + ") == std::string::npos ? said.substr(0, said.find('@')) : "several";
}

std::vector<Verdict> verdicts_of(const Table& cases, const std::string& file) {
  std::vector<Verdict> list;
  for (const std::string& name : texts(cases, "verdict", file)) {
    constexpr auto kNames = names(Verdict{});
    const auto found = std::find(kNames.begin(), kNames.end(), name);
    if (found == kNames.end()) throw DataError(Location{file}, "there is no verdict '" + name + "'");
    list.push_back(static_cast<Verdict>(found - kNames.begin()));
  }
  return list;
}

}  // namespace

std::string trial_page(const fs::path& folder) {
  const ordered_json summary = read_json(folder / "summary.json");
  const Table cases = read_csv(folder / "cases.csv");
  const std::string file = (folder / "cases.csv").string();
  const std::vector<double> named = numbers(cases, "named", file), probability = numbers(cases, "probability", file);
  const std::vector<std::string> families = texts(cases, "family", file), truths = texts(cases, "truth", file),
                                 hidden = texts(cases, "hidden", file), said = texts(cases, "said", file);
  const std::vector<Verdict> verdicts = verdicts_of(cases, file);
  struct Row {
    int cases = 0, right = 0, declined = 0;
    std::map<std::string, int> columns;  // of the matrix
    std::string instead;                 // what was said and not hidden
  };
  std::map<std::string, Row> rows;
  std::array<std::array<double, 3>, kBins> bins{};  // cases, stated, right
  for (std::size_t i = 0; i < cases.rows(); ++i) {
    const std::string& family = families[i];
    const Verdict verdict = verdicts[i];
    if (family == "pysindy") continue;
    const bool nothing = family == "nothing";
    const bool right = nothing ? verdict == Verdict::nothing_missing : named[i] > 0.5;
    Row& row = rows[(family == "outside" ? "outside: " : "") + truths[i]];
    const std::string what = answer(verdict, said[i]);
    ++row.cases;
    row.right += right;
    row.declined += verdict == Verdict::unknown;
    ++row.columns[right && family == "single" ? truths[i] : what];
    if (!right && verdict != Verdict::unknown) {
      const bool several = family == "pair" || family == "triple";
      const std::string whole = verdict == Verdict::nothing_missing ? what : said[i];
      row.instead += (row.instead.empty() ? "" : "; ") + whole + (several ? " for " + hidden[i] : "");
    }
    if (verdict != Verdict::named && verdict != Verdict::ambiguous) continue;
    auto& bin = bins[static_cast<std::size_t>(std::clamp(static_cast<int>(probability[i] * kBins), 0, kBins - 1))];
    bin[0] += 1.0;
    bin[1] += probability[i];
    bin[2] += right;
  }
  ordered_json confusion = ordered_json::array(), matrix = ordered_json::array(), calibration = ordered_json::array();
  for (const auto& [name, row] : rows) {
    confusion.push_back({name, row.cases, row.right, row.instead, row.declined});
    if (name != "pair" && name != "triple") matrix.push_back({{"hidden", name}, {"said", row.columns}});
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
       {"origin", origin(folder)},
       {"confusion", confusion},
       {"matrix", matrix},
       {"calibration", calibration}});
}

}  // namespace bayesctrl
