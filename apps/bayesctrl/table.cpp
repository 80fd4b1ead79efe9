#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "experiment/check.hpp"
#include "experiment/write.hpp"
#include "io/files.hpp"

namespace bayesctrl {

namespace {

struct TableCommand {
  std::vector<std::string> folders;
  std::string against;
  std::string out;
  std::string format = "md";
  bool json = false;
};

Table gather(const TableCommand& command) {
  const Table table = gather_tables({command.folders.begin(), command.folders.end()});
  if (command.against.empty()) return table;
  read_spec(command.against, {}, "published_table");  // or says of what kind it is
  return compare(table, read_published(command.against));
}

std::string render(const Table& table, const std::string& format) {
  if (format == "csv") return to_csv(table);
  if (format == "json") return to_json(table).dump(2) + "\n";
  return format == "text" ? to_text(table, kShownDigits) : to_markdown(table, kShownDigits);
}

/// PREFIX.csv, PREFIX.md and PREFIX.json.
void write_table(const Table& table, const std::string& prefix) {
  FileBatch batch;
  for (const std::string format : {"csv", "md", "json"}) batch.add(prefix + "." + format, render(table, format));
  batch.commit();
}

}  // namespace

void declare_table(CLI::App& app, ExitCode& /*exit*/) {
  auto command = std::make_shared<TableCommand>();
  CLI::App* sub = app.add_subcommand("table", "Gather the tables of result folders into one, for people or programs");
  sub->add_option("DIR", command->folders, "Result folders of `run`, or table.csv files")->required();
  sub->add_option("--against", command->against, "Published numbers to set beside, e.g. configs/paper_table2.yaml")
      ->type_name("SPEC");
  sub->add_option("--out", command->out, "Write PREFIX.csv, PREFIX.md and PREFIX.json instead of printing")
      ->type_name("PREFIX");
  add_format_option(*sub, command->format);
  add_json_option(*sub, command->json);
  sub->footer(
      "Examples:\n"
      "  bayesctrl table results/exp1 results/exp2 --format csv\n"
      "  bayesctrl table results/exp1 --against configs/paper_table2.yaml --out exp1_beside_paper");
  sub->callback([command] {
    const Table table = gather(*command);
    if (!command->out.empty()) write_table(table, command->out);
    if (command->json) {
      std::cout << nlohmann::ordered_json{{"rows", to_json(table)}}.dump(2) << "\n";
    } else if (command->out.empty()) {
      std::cout << render(table, command->format);
    }
  });
}

void declare_check(CLI::App& app, ExitCode& exit) {
  struct Command {
    std::vector<std::string> folders;
    std::string against;
    std::string out;
    bool json = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("check", "Compare results with published numbers; exit 1 if any cell is violated");
  sub->add_option("DIR", command->folders, "Result folders of `run`, or table.csv files")->required();
  sub->add_option("--against", command->against, "Published numbers with tolerances, e.g. configs/paper_table2.yaml")
      ->type_name("SPEC")
      ->required();
  sub->add_option("--out", command->out,
                  "Write the whole comparison to PREFIX.csv, PREFIX.md and PREFIX.json, whatever it says")
      ->type_name("PREFIX");
  add_json_option(*sub, command->json);
  sub->footer(
      "Example:\n"
      "  bayesctrl check results/exp1 results/exp2 results/exp3 --against configs/paper_table2.yaml");
  sub->callback([command, &exit] {
    read_spec(command->against, {}, "published_table");
    PublishedTable published = read_published(command->against);
    const Table results = gather_tables({command->folders.begin(), command->folders.end()});
    const std::vector<std::string> absent = take_absent(published, results);
    if (published.cells.empty()) {
      throw DataError({command->against}, "has no cell of the experiments in these folders");
    }
    const Table comparison = compare(results, published);
    const std::vector<std::string> violated = violations(comparison);
    if (!command->out.empty()) write_table(comparison, command->out);
    if (command->json) {
      std::cout << nlohmann::ordered_json{{"name", published.name},
                                          {"cells", to_json(comparison)},
                                          {"violated", violated.size()},
                                          {"absent", absent}}
                       .dump(2)
                << "\n";
    } else {
      for (const std::string& line : violated) std::cout << "violated: " << line << "\n";
      for (const std::string& line : absent) std::cout << line << "\n";
      std::cout << published.name << ": " << published.cells.size() - violated.size() << " of "
                << published.cells.size() << " cells hold\n";
    }
    if (!violated.empty()) exit = ExitCode::check_failed;
  });
}

}  // namespace bayesctrl
