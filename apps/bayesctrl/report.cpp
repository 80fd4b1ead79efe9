#include "report/report.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "experiment/check.hpp"
#include "experiment/write.hpp"

namespace bayesctrl {

namespace {

struct ReportCommand {
  std::vector<std::string> folders;
  std::string against;
  std::string out;
};

/// The tables of the folders that have one, which are those of experiments, beside published numbers.
std::optional<Published> published_for(const ReportCommand& command) {
  std::filesystem::path file = command.against;
  std::vector<std::filesystem::path> folders;
  for (const std::filesystem::path folder : command.folders) {
    if (!std::filesystem::exists(folder / "table.csv")) continue;
    folders.push_back(folder);
    if (file.empty() && std::filesystem::exists(folder / kPublishedFile)) file = folder / kPublishedFile;
  }
  if (file.empty()) return std::nullopt;
  const PublishedTable published = read_published(file);
  return Published{published.name, published.source, compare(gather_tables(folders), published)};
}

}  // namespace

void declare_report(CLI::App& app, ExitCode& /*exit*/) {
  auto command = std::make_shared<ReportCommand>();
  CLI::App* sub = app.add_subcommand(
      "report", "Write report.html, a page to look at, from the results of experiments, a diagnosis or a trial");
  sub->add_option("DIR", command->folders, "Folders that run, diagnose or trial wrote; experiments share one page")
      ->required();
  sub->add_option("--against", command->against,
                  "Published numbers to set beside experiments; default: those that run found in the spec")
      ->type_name("SPEC");
  sub->add_option("--out", command->out,
                  "The page; default: report.html in the folder, or of several experiments in the folder above all")
      ->type_name("FILE");
  sub->footer(
      "Examples:\n"
      "  bayesctrl report results/exp1 results/exp2 --out both.html\n"
      "  bayesctrl report results/diagnose/slide");
  sub->callback([command] {
    const std::optional<Published> published = published_for(*command);
    for (const std::filesystem::path& file : write_reports({command->folders.begin(), command->folders.end()},
                                                           published ? &*published : nullptr, command->out)) {
      std::cout << "written: " << file.string() << "\n";
    }
  });
}

}  // namespace bayesctrl
