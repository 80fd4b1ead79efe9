#include "bench/bench.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "report/report.hpp"
#include "terminal/progress.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;

/// Row by row what a person reads.
void print(const Table& table) {
  const auto text = [&](std::string_view column, std::size_t row) {
    const Cell cell = table.find(column)->at(row);
    const auto* words = std::get_if<std::string>(&cell);
    const auto* number = std::get_if<double>(&cell);
    return words != nullptr ? *words : number != nullptr ? format(*number, 3) : std::string();
  };
  for (std::size_t row = 0; row < table.rows(); ++row) {
    const bool ok = text("status", row) == "ok";
    std::cout << text("machine", row) << ": " << text(ok ? "verdict" : "status", row);
    if (!ok) std::cout << " (" << text("reason", row) << ")";
    std::cout << "\n";
    for (const std::string_view column : {"published", "found", "open", "missed", "more"}) {
      const std::string said = text(column, row);
      if ((ok || column == "published") && !said.empty()) std::cout << "  " << column << ": " << said << "\n";
    }
    if (!ok) continue;
    const std::string best = text("best_published", row);
    std::cout << "  free runs err by " << text("before", row) << " " << text("unit", row) << " as given, "
              << (best.empty() ? "" : best + " at best as published, ") << text("after", row) << " corrected (noise "
              << text("noise", row) << ")\n";
  }
}

}  // namespace

void declare_bench(CLI::App& app, ExitCode& exit) {
  struct Command {
    std::string spec, out;
    int jobs = 0;
    bool no_report = false;
    Loudness loudness;
    std::vector<std::string> assignments;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(
      "bench", "Diagnose real machines, and compare what is found with what others have published of them");
  sub->add_option("SPEC", command->spec, "YAML spec of a bench: diagnoses, published effects and errors")->required();
  sub->add_option("--out", command->out,
                  "Folder for bench.csv, bench.json, bench.md and a folder of each machine; default: results/NAME")
      ->type_name("DIR");
  add_jobs_option(*sub, command->jobs);
  sub->add_flag("--no-report", command->no_report, "Write no report.html for the machines");
  add_set_option(*sub, command->assignments);
  add_loudness(*sub, command->loudness);
  sub->footer(
      "A machine whose recordings are not here is skipped.\n"
      "Example:\n"
      "  bayesctrl bench configs/bench.yaml");
  sub->callback([command, &exit] {
    keep_memory();
    const Bench bench = read_bench(read_spec(command->spec, command->assignments, "bench"));
    end_at_once("interrupted: diagnoses that were written are whole; the table was not\n");
    const fs::path folder = command->out.empty() ? fs::path("results") / slug(bench.name) : fs::path(command->out);
    const Loudness& loudness = command->loudness;
    Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "machines");
    const Table table =
        run_bench(bench, folder, {command->jobs, [&](std::size_t done, std::size_t total) { progress(done, total); }});
    progress.clear();
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const std::string status = std::get<std::string>(table.find("status")->at(row));
      const std::string name = std::get<std::string>(table.find("machine")->at(row));
      if (status == "failed") exit = ExitCode::partial;
      if (status == "ok" && !command->no_report) write_reports({folder / slug(name)});
    }
    if (loudness.json) {
      std::cout << nlohmann::ordered_json{{"folder", folder.string()}, {"machines", to_json(table)}}.dump(2) << "\n";
    } else if (!loudness.quiet) {
      print(table);
      std::cout << "written to " << folder.string() << "\n";
    }
  });
}

}  // namespace bayesctrl
