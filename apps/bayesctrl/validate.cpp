#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "experiment/read.hpp"

namespace bayesctrl {

void declare_validate(CLI::App& app, ExitCode& exit) {
  struct Command {
    std::vector<std::string> specs;
    Overrides overrides;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("validate", "Read specs without running them; every bad one is reported");
  sub->add_option("SPEC", command->specs, "YAML spec of a study")->required();
  add_set_option(*sub, command->overrides.assignments);
  sub->callback([command, &exit] {
    for (const std::string& spec : command->specs) {
      try {
        const std::vector<Study> studies = read_studies(spec, command->overrides);
        std::cout << spec << ": ok, study '" << studies.front().name << "', "
                  << studies.front().controllers.items.size() << " controllers";
        if (studies.size() > 1) std::cout << ", sweep of " << studies.size() << " points";
        std::cout << "\n";
      } catch (const Error& error) {
        std::cerr << "error: " << error.what() << "\n";
        exit = error.code();
      }
    }
  });
}

}  // namespace bayesctrl
