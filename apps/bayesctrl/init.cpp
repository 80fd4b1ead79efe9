#include <CLI/CLI.hpp>
#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "inspect/starter.hpp"
#include "io/files.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

namespace {

struct InitOptions {
  std::vector<std::string> recordings;
  std::string plant;
  std::string out;
  NamedColumns columns;
  bool force = false;
};

void add_options(CLI::App& command, InitOptions& options, const std::string& file) {
  std::vector<std::string> plants;
  for (const std::string_view name : names_of(static_cast<const Plant*>(nullptr))) plants.emplace_back(name);
  command.add_option("--plant", options.plant, "Kind of machine: bayesctrl list plants")->check(one_of(plants));
  options.out = file;
  command.add_option("--out", options.out, "The spec to write")->type_name("FILE")->capture_default_str();
  command.add_flag("--force", options.force, "Overwrite a file that is there");
}

void write(const InitOptions& options, const std::string& text, const std::string& next) {
  if (!options.force && std::filesystem::exists(options.out)) {
    throw SpecError({options.out}, "is there already: --force overwrites it, --out names another file");
  }
  write_file(options.out, text);
  std::cout << "written: " << options.out << "\nnext: " << next << " " << options.out << "\n";
}

}  // namespace

void declare_init(CLI::App& app, ExitCode& /*exit*/) {
  CLI::App* sub = app.add_subcommand("init", "Write a commented spec to start from");
  sub->require_subcommand(1);

  auto study = std::make_shared<InitOptions>();
  CLI::App* experiment = sub->add_subcommand("experiment", "A spec of an experiment, which runs as it is");
  add_options(*experiment, *study, "experiment.yaml");
  experiment->callback([study] {
    write(*study, experiment_starter(study->plant.empty() ? Pendulum::kName : study->plant),
          "set the machine's parameters and the task; bayesctrl validate says what is wrong; then bayesctrl run");
  });

  auto doubt = std::make_shared<InitOptions>();
  CLI::App* diagnosis =
      sub->add_subcommand("diagnosis", "A spec of a diagnosis, with columns guessed from a recording");
  diagnosis->add_option("FILE", doubt->recordings, "Recordings of the real machine: CSV or MATLAB files")->required();
  diagnosis->add_option("--position", doubt->columns.position, "Its columns, where no name is known; one per joint")
      ->type_name("COLUMN")
      ->delimiter(',')
      ->allow_extra_args(false);
  diagnosis->add_option("--input", doubt->columns.input, "The same of the input")
      ->type_name("COLUMN")
      ->delimiter(',')
      ->allow_extra_args(false);
  diagnosis->add_option("--time", doubt->columns.time, "The same of the time")->type_name("COLUMN");
  add_options(*diagnosis, *doubt, "diagnosis.yaml");
  diagnosis->callback([doubt] {
    write(*doubt,
          diagnosis_starter({doubt->recordings.begin(), doubt->recordings.end()}, doubt->plant,
                            std::filesystem::path(doubt->out).parent_path(), doubt->columns),
          "check the guesses in its comments (columns, units) and set the model's parameters; bayesctrl validate "
          "says what is wrong; then bayesctrl diagnose");
  });
}

}  // namespace bayesctrl
