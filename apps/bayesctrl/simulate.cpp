#include "experiment/simulate.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "base/format.hpp"
#include "commands.hpp"
#include "diagnose/verdict/simulate_model.hpp"
#include "io/files.hpp"
#include "terminal/plot.hpp"
#include "terminal/terminal.hpp"

namespace bayesctrl {

namespace {

/// The table to a file, or to standard output; plots of position and input go to standard error.
void give(const Table& table, int digits, const std::string& out, bool plotted) {
  const std::string csv = to_csv(table, digits);
  if (out.empty() || out == "-") {
    std::cout << csv;
  } else {
    write_file(out, csv);
  }
  if (!plotted) return;
  std::vector<std::string> columns;
  for (const Column& column : table.columns) {
    if (column.name.starts_with("q") || column.name.starts_with("u")) columns.push_back(column.name);
  }
  std::cerr << plot_columns(table, columns, {terminal_width(STDERR_FILENO), 5, has_colour(STDERR_FILENO)});
}

}  // namespace

void declare_simulate(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string spec;
    std::string input;
    std::string out;
    double horizon = 0.0;
    bool plot = false;
    Overrides overrides;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      app.add_subcommand("simulate", "Free run of a study's machine or of a diagnosed model, without any controller");
  sub->add_option("SPEC", command->spec,
                  "YAML spec of a study (its model, initial_state and duration are used), or model.yaml of a diagnosis")
      ->required();
  sub->add_option("--input", command->input,
                  "CSV with columns t and u (u1, u2, ...), each input held until the next row; default: no input")
      ->type_name("FILE");
  sub->add_option("--out", command->out, "CSV to write t, q, v, u to; default, and -: standard output")
      ->type_name("FILE");
  sub->add_option("--horizon", command->horizon,
                  "model.yaml: seconds of each free run, whose start is fitted; default: the diagnosis's horizon_s")
      ->check(number_check(kPositive));
  sub->add_flag("--plot", command->plot, "Draw position and input over time on standard error");
  add_set_option(*sub, command->overrides.assignments);
  sub->footer(
      "Example:\n"
      "  bayesctrl simulate results/diagnose/slide/model.yaml --input test1.csv --horizon 1 --out run.csv");
  sub->callback([command] {
    if (is_model_file(command->spec)) {
      if (command->input.empty()) throw CLI::RequiredError("--input (a recording with the columns of model.yaml)");
      const ModelFile file = read_model_file(read_yaml(command->spec));
      const SimulatedModel run =
          simulate_model(file, command->input, command->horizon > 0.0 ? command->horizon : file.horizon);
      give(run.table, 10, command->out, command->plot);
      std::cerr << "measured less simulated: " << format(run.rms, 5) << " RMS\n";
      return;
    }
    const Study study = read_studies(command->spec, command->overrides).front();
    give(simulate(study, command->input), 0, command->out, command->plot);
  });
}

}  // namespace bayesctrl
