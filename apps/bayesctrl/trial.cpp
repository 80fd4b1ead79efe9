#include "trial/trial.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "diagnose/settings.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/provenance.hpp"
#include "io/read.hpp"
#include "report/report.hpp"
#include "terminal/progress.hpp"

namespace bayesctrl {

void declare_trial(CLI::App& app, ExitCode& exit) {
  struct Command {
    std::string spec, out;
    std::vector<std::uint64_t> seeds;
    double scale = 1.0;
    int jobs = 0;
    bool no_report = false;
    bool resume = false;
    Loudness loudness;
    std::vector<std::string> assignments;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("trial", "Prove the diagnosis on machines with concealed effects");
  sub->add_option("SPEC", command->spec, "YAML spec of a trial: how many cases of which kind")->required();
  sub->add_option("--seed", command->seeds, "Seeds instead of the spec's; one trial for each")->check(seed_check());
  sub->add_option("--scale", command->scale, "Part of the spec's numbers of cases, e.g. 0.1")
      ->check(number_check(between(0.001, 100.0)));
  sub->add_option("--out", command->out, "Folder; default: results/NAME")->type_name("DIR");
  sub->add_option("-j,--jobs", command->jobs, "Processes at a time; 0: one per core")
      ->check(CLI::Range(0, kMostJobs))
      ->capture_default_str();
  sub->add_flag("--resume", command->resume,
                "Keep what an interrupted trial of the same machines has diagnosed, by the same program");
  sub->add_flag("--no-report", command->no_report, "Write no report.html");
  add_set_option(*sub, command->assignments);
  add_loudness(*sub, command->loudness);
  sub->footer(
      "Examples:\n"
      "  bayesctrl trial configs/trial.yaml --scale 0.1 --seed 7\n"
      "  bayesctrl trial configs/trial.yaml --set outside=0 --set nothing=0");
  sub->callback([command, &exit] {
    TrialSpec spec = read<TrialSpec>(read_spec(command->spec, command->assignments, "trial"));
    for (int* count : {&spec.per_effect, &spec.pairs, &spec.triples, &spec.many, &spec.outside, &spec.nothing,
                       &spec.short_recordings, &spec.cut, &spec.nonsense}) {
      if (*count > 0) *count = std::max(1, static_cast<int>(*count * command->scale));
    }
    const std::filesystem::path folder =
        command->out.empty() ? std::filesystem::path("results") / slug(spec.name) : std::filesystem::path(command->out);
    if (command->seeds.empty()) command->seeds.push_back(spec.seed);
    const Loudness& loudness = command->loudness;
    Progress progress(Progress::choose(loudness.progress, loudness.quiet || loudness.json), "cases");
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const std::uint64_t seed : command->seeds) {
      spec.seed = seed;
      const auto place = command->seeds.size() == 1 ? folder : folder / ("seed-" + std::to_string(seed));
      const TrialResult result = run_trial(
          spec, place,
          {"/proc/self/exe", command->jobs, [&](const std::string& line) { progress.say(line); },
           [&](std::size_t done, std::size_t total) { progress(done, total); }, interrupted, command->resume});
      if (interrupted()) {
        progress.clear();
        if (result.sealed) {
          std::cerr << "interrupted: cases and diagnoses in " << place.string()
                    << " are whole; the same command with --resume does the rest\n";
        } else {
          std::cerr << "interrupted while machines were drawn: run the same command again\n";
        }
        exit = ExitCode::interrupted;
        return;
      }
      nlohmann::ordered_json origin =
          provenance(std::filesystem::path(command->spec).filename().string(), to_json(spec));
      origin["settings"] = to_json(kSettings);
      write_file(place / "provenance.json", origin.dump(2) + "\n");
      if (!command->no_report) write_reports({place});
      list.push_back({{"folder", place.string()}, {"summary", result.summary}});
      if (loudness.quiet || loudness.json) continue;
      std::cout << result.markdown << "\nwritten to " << place.string() << "\n";
    }
    if (loudness.json) std::cout << nlohmann::ordered_json{{"trials", list}}.dump(2) << "\n";
  });
}

}  // namespace bayesctrl
