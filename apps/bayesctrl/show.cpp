#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "inspect/kinds.hpp"

namespace bayesctrl {

void declare_show(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string spec;
    std::vector<std::string> assignments;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand("show", "Print a spec of any kind with every default, as YAML that reads back");
  sub->add_option("SPEC", command->spec, "YAML spec; files that it names stay relative to its folder")->required();
  add_set_option(*sub, command->assignments);
  sub->footer(
      "Example:\n"
      "  bayesctrl show configs/exp1.yaml --set learner.probing_input=5");
  sub->callback([command] {
    const Node spec = read_spec(command->spec, command->assignments);
    std::cout << kind_of(spec).resolved(spec);
  });
}

}  // namespace bayesctrl
