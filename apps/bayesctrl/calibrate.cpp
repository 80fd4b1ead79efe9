#include "experiment/calibrate.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "experiment/check.hpp"
#include "terminal/progress.hpp"

namespace bayesctrl {

namespace {

struct CalibrateCommand {
  std::string spec;
  int jobs = 0;
  std::size_t show = 3;
  Loudness loudness;
};

ExitCode run(const CalibrateCommand& command) {
  const Loudness& loudness = command.loudness;
  Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "searches");
  std::vector<CalibrationResult> ended = calibrate(
      command.spec, command.jobs, [&](std::size_t done, std::size_t total) { progress(done, total); }, interrupted);
  const std::size_t searches = ended.size();
  const std::vector<CalibrationResult> results = distinct(std::move(ended));
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (std::size_t i = 0; i < std::min(command.show, results.size()); ++i) {
    const CalibrationResult& result = results[i];
    if (loudness.json) {
      list.push_back({{"score", result.score},
                      {"searches", result.searches},
                      {"settings", result.assignments},
                      {"cells", to_json(result.comparison)}});
      continue;
    }
    std::cout << "score " << result.score << ", " << violations(result.comparison).size()
              << " cells violated, found by " << result.searches << " of " << searches << " searches\n";
    for (const std::string& assignment : result.assignments) std::cout << "  " << assignment << "\n";
    std::cout << to_markdown(result.comparison, 5) << "\n";
  }
  if (loudness.json) std::cout << nlohmann::ordered_json{{"candidates", list}}.dump(2) << "\n";
  if (!interrupted()) return ExitCode::ok;
  progress.say("interrupted: these are the best of the searches that ended; the same command begins anew");
  return ExitCode::interrupted;
}

}  // namespace

void declare_calibrate(CLI::App& app, ExitCode& exit) {
  auto command = std::make_shared<CalibrateCommand>();
  CLI::App* sub = app.add_subcommand("calibrate", "Search settings that a publication does not report");
  sub->add_option("SPEC", command->spec, "YAML spec of a calibration, e.g. configs/calibrate_exp1.yaml")->required();
  add_jobs_option(*sub, command->jobs);
  sub->add_option("--show", command->show, "How many of the best candidates are shown, each once")
      ->capture_default_str();
  add_loudness(*sub, command->loudness);
  sub->callback([command, &exit] { exit = run(*command); });
}

}  // namespace bayesctrl
