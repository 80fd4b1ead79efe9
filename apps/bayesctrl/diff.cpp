#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "inspect/difference.hpp"
#include "io/text.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

/// One table for programs: settings above metrics, told apart by the column `kind`.
Table joined(const ResultDifference& difference) {
  const auto with_kind = [](Table table, const std::string& kind) {
    const std::vector<Cell> kinds(table.rows(), Cell(kind));
    table.columns.front().name = "name";
    table.columns.insert(table.columns.begin(), {"kind", "", kinds});
    return table;
  };
  Table table = with_kind(difference.settings, "setting");
  append(table, with_kind(difference.metrics, "metric"));
  return table;
}

/// For people: long texts are cut.
Table shortened(Table table) {
  constexpr std::size_t kLongest = 50;
  for (Column& column : table.columns) {
    auto* cells = std::get_if<std::vector<Cell>>(&column.cells);
    for (std::size_t i = 0; cells != nullptr && i < cells->size(); ++i) {
      if (const auto* text = std::get_if<std::string>(&(*cells)[i])) (*cells)[i] = shown(*text, kLongest);
    }
  }
  return table;
}

std::string render(const ResultDifference& difference, const std::string& format) {
  if (format == "csv") return to_csv(joined(difference));
  if (format == "json") {
    return ordered_json{{"differ", !difference.empty()},
                        {"settings", to_json(difference.settings)},
                        {"metrics", to_json(difference.metrics)}}
               .dump(2) +
           "\n";
  }
  std::string text;
  for (const Table* table : {&difference.settings, &difference.metrics}) {
    if (table->rows() == 0) continue;
    text += (text.empty() ? "" : "\n") + (format == "text" ? to_text(shortened(*table), kShownDigits)
                                                           : to_markdown(shortened(*table), kShownDigits));
  }
  return text.empty() ? "no difference\n" : text;
}

}  // namespace

void declare_diff(CLI::App& app, ExitCode& exit) {
  struct Options {
    std::vector<std::string> folders;
    std::string format = "text";
    bool json = false;
    bool exit_code = false;
  };
  auto options = std::make_shared<Options>();
  CLI::App* sub =
      app.add_subcommand("diff", "Compare results: settings and metrics that are not the same in all of them");
  sub->add_option("DIR", options->folders,
                  "Two or more folders that run, diagnose or trial wrote; the first is the reference")
      ->required()
      ->expected(2, -1);
  add_format_option(*sub, options->format);
  add_json_option(*sub, options->json);
  sub->add_flag("--exit-code", options->exit_code, "Exit with 1 if there is a difference");
  sub->footer(
      "Example:\n"
      "  bayesctrl diff results/exp1 results/probe5 --format md");
  sub->callback([options, &exit] {
    std::vector<ResultValues> results;
    for (const std::string& folder : options->folders) results.push_back(read_results(folder));
    const ResultDifference found = difference(results);
    std::cout << render(found, options->json ? "json" : options->format);
    if (options->exit_code && !found.empty()) exit = ExitCode::check_failed;
  });
}

}  // namespace bayesctrl
