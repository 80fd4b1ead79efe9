#include "experiment/calibrate.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "experiment/check.hpp"
#include "progress.hpp"

namespace bayesctrl {

namespace {

struct CalibrateCommand {
  std::string spec;
  int jobs = 0;
  std::size_t show = 3;
  std::string progress;
  bool quiet = false;
  bool json = false;
};

ExitCode run(const CalibrateCommand& command) {
  Progress progress(Progress::choose(command.progress, command.quiet || command.json));
  const std::vector<CalibrationResult> results = calibrate(
      command.spec, command.jobs, [&](std::size_t done, std::size_t total) { progress(done, total); }, interrupted);
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < std::min(command.show, results.size()); ++i) {
    const CalibrationResult& result = results[i];
    if (command.json) {
      list.push_back(
          {{"score", result.score}, {"settings", result.assignments}, {"cells", to_json(result.comparison)}});
      continue;
    }
    std::cout << "score " << result.score << ", " << violations(result.comparison).size() << " cells violated\n";
    for (const std::string& assignment : result.assignments) std::cout << "  " << assignment << "\n";
    std::cout << to_markdown(result.comparison, 5) << "\n";
  }
  if (command.json) std::cout << list.dump(2) << "\n";
  return interrupted() ? ExitCode::interrupted : ExitCode::ok;
}

}  // namespace

void declare_calibrate(CLI::App& app, ExitCode& exit) {
  auto command = std::make_shared<CalibrateCommand>();
  CLI::App* sub = app.add_subcommand("calibrate", "Search settings that a publication does not report");
  sub->add_option("SPEC", command->spec, "YAML spec of a calibration, e.g. configs/calibrate_exp1.yaml")->required();
  sub->add_option("--jobs", command->jobs, "Threads; 0: all cores. Results do not depend on it")
      ->check(CLI::Range(0, 4096));
  sub->add_option("--show", command->show, "How many of the best searches are shown")->capture_default_str();
  sub->add_option("--progress", command->progress, "How progress is shown on standard error")
      ->check(CLI::IsMember({"none", "bar", "text"}));
  sub->add_flag("--quiet", command->quiet, "No progress");
  sub->add_flag("--json", command->json, "Print one JSON list on standard output and nothing else");
  sub->callback([command, &exit] { exit = run(*command); });
}

}  // namespace bayesctrl
