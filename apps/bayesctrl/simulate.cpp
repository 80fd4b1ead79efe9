#include "experiment/simulate.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "io/files.hpp"

namespace bayesctrl {

void declare_simulate(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string spec;
    std::string input;
    std::string out;
    Overrides overrides;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("simulate", "Free run of a study's machine, without any controller");
  sub->add_option("SPEC", command->spec, "YAML spec of a study: its model, initial_state and duration are used")
      ->required();
  sub->add_option("--input", command->input,
                  "CSV with columns t and u (u1, u2, ...), each input held until the next row; default: no input");
  sub->add_option("--out", command->out, "CSV to write t, q, v, u to; default: standard output")->type_name("FILE");
  add_set_option(*sub, command->overrides.assignments);
  sub->callback([command] {
    const Study study = read_studies(command->spec, command->overrides).front();
    const std::string csv = to_csv(simulate(study, command->input));
    if (command->out.empty()) {
      std::cout << csv;
    } else {
      write_file(command->out, csv);
    }
  });
}

}  // namespace bayesctrl
