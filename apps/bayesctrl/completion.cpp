#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "io/provenance.hpp"
#include "usage.hpp"

namespace bayesctrl {

void declare_completion(CLI::App& app, ExitCode& /*exit*/) {
  auto shell = std::make_shared<std::string>();
  CLI::App* sub = app.add_subcommand("completion", "Print a script that completes commands, options and files");
  sub->add_option("SHELL", *shell, "The shell")->required()->check(one_of({"bash", "zsh", "fish"}));
  sub->footer(
      "bash:  source <(bayesctrl completion bash)\n"
      "zsh:   source <(bayesctrl completion zsh)\n"
      "fish:  bayesctrl completion fish | source");
  sub->callback([shell, &app] { std::cout << completion_script(command_tree(app), *shell); });
}

void declare_man(CLI::App& app, ExitCode& /*exit*/) {
  CLI::App* sub =
      app.add_subcommand("man", "Print the manual page, made of what --help says: bayesctrl man | man -l -");
  sub->callback([&app] { std::cout << manual_page(command_tree(app), program_version()); });
}

}  // namespace bayesctrl
