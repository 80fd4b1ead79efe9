#include "experiment/simulate.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "diagnose/simulate_model.hpp"
#include "io/files.hpp"

namespace bayesctrl {

void declare_simulate(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string spec;
    std::string input;
    std::string out;
    double horizon = 0.0;
    Overrides overrides;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      app.add_subcommand("simulate", "Free run of a study's machine or of a diagnosed model, without any controller");
  sub->add_option("SPEC", command->spec,
                  "YAML spec of a study (its model, initial_state and duration are used), or model.yaml of a diagnosis")
      ->required();
  sub->add_option("--input", command->input,
                  "CSV with columns t and u (u1, u2, ...), each input held until the next row; default: no input");
  sub->add_option("--out", command->out, "CSV to write t, q, v, u to; default: standard output")->type_name("FILE");
  sub->add_option("--horizon", command->horizon,
                  "model.yaml: seconds of each free run, whose start is fitted; default: the diagnosis's horizon_s")
      ->check(CLI::PositiveNumber);
  add_set_option(*sub, command->overrides.assignments);
  sub->callback([command] {
    if (is_model_file(command->spec)) {
      if (command->input.empty()) throw CLI::RequiredError("--input (a recording with the columns of model.yaml)");
      const ModelFile file = read_model_file(read_yaml(command->spec));
      const SimulatedModel run =
          simulate_model(file, command->input, command->horizon > 0.0 ? command->horizon : file.horizon);
      const std::string csv = to_csv(run.table, 10);
      if (command->out.empty()) {
        std::cout << csv;
      } else {
        write_file(command->out, csv);
      }
      std::cerr << "measured less simulated: " << format(run.rms, 5) << " RMS\n";
      return;
    }
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
