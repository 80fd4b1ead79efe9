#include "sweep/sensitivity.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/provenance.hpp"
#include "report/claims_picture.hpp"
#include "terminal/progress.hpp"

namespace bayesctrl {

namespace {

namespace fs = std::filesystem;
using nlohmann::ordered_json;

struct SensitivityCommand {
  std::string spec, out;
  std::vector<std::string> assignments;
  int jobs = 0, limit = 0;
  Loudness loudness;
};

/// The columns that people look at first, shares in per cent.
Table in_percent(const Table& claims) {
  Table table;
  for (const char* name : {"group", "claim", "n", "n_failed"}) table.columns.push_back(*claims.find(name));
  for (const char* name : {"share", "low", "high", "share_lowest", "share_highest"}) {
    std::vector<double> shares = numbers(claims, name, "claims.csv");
    for (double& share : shares) share *= 100.0;
    table.columns.push_back({name, "%", std::move(shares)});
  }
  table.columns.push_back(*claims.find("setting"));
  return table;
}

void write(const SensitivityResult& result, const Sensitivity& spec, const std::string& spec_name,
           const fs::path& out) {
  ordered_json summary{{"name", spec.name}, {"source", spec.source}, {"claims", to_json(result.claims)}};
  FileBatch batch;
  batch.add(out / "claims.csv", to_csv(result.claims, kShownDigits));
  batch.add(out / "by_setting.csv", to_csv(result.by_setting));
  batch.add(out / "claims.md", to_markdown(in_percent(result.claims), 3));
  batch.add(out / "claims.svg", claims_picture(result.claims, result.by_setting));
  batch.add(out / "summary.json", summary.dump(2) + "\n");
  batch.add(out / "provenance.json", provenance(spec_name, to_json(spec)).dump(2) + "\n");
  batch.commit();
}

ExitCode run(const SensitivityCommand& command) {
  const Node node = read_spec(command.spec, command.assignments, "sensitivity");
  const Sensitivity spec = read_sensitivity(node);
  const fs::path out = command.out.empty() ? fs::path("results") / slug(spec.name) : fs::path(command.out);
  const bool silent = command.loudness.quiet || command.loudness.json;
  Progress progress(Progress::choose(command.loudness.progress, silent), "runs");
  SensitivityOptions options;
  options.jobs = command.jobs;
  options.limit = command.limit;
  options.progress = [&](std::size_t done, std::size_t total) { progress(done, total); };
  options.stop = interrupted;
  const std::optional<SensitivityResult> result = run_sensitivity(spec, folder_of(node), out, options);
  progress.clear();
  if (!result) {
    std::cerr << "interrupted: finished runs are kept; the same command does the rest\n";
    return ExitCode::interrupted;
  }
  write(*result, spec, fs::path(command.spec).filename().string(), out);
  if (command.loudness.json)
    std::cout << ordered_json{{"folder", out.string()}, {"claims", to_json(result->claims)}}.dump(2) << "\n";
  else if (!command.loudness.quiet)
    std::cout << to_text(in_percent(result->claims), 3) << "written to " << out.string() << "\n";
  return ExitCode::ok;
}

}  // namespace

void declare_sensitivity(CLI::App& app, ExitCode& exit) {
  auto command = std::make_shared<SensitivityCommand>();
  CLI::App* sub = app.add_subcommand(
      "sensitivity", "Say in which share of what its unreported settings may be a publication's claims hold");
  sub->add_option("SPEC", command->spec, "YAML spec of experiments, their uncertain settings, and claims")->required();
  sub->add_option("--out", command->out, "Folder; default: results/NAME")->type_name("DIR");
  add_set_option(*sub, command->assignments);
  sub->add_option("--limit", command->limit, "Only the first N draws")
      ->type_name("N")
      ->check(CLI::Range(1, static_cast<int>(kMostSweepPoints)));
  add_jobs_option(*sub, command->jobs);
  add_loudness(*sub, command->loudness);
  sub->footer(
      "Example:\n"
      "  bayesctrl sensitivity configs/sensitivity.yaml --limit 200 --out results/sensitivity-200\n"
      "Writes claims.csv, claims.md and claims.svg, by_setting.csv, and a sweep's folder for each experiment.");
  sub->callback([command, &exit] {
    keep_memory();
    exit = run(*command);
  });
}

}  // namespace bayesctrl
