#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "inspect/kinds.hpp"

namespace bayesctrl {

void declare_validate(CLI::App& app, ExitCode& exit) {
  struct Command {
    std::vector<std::string> specs, assignments;
    bool json = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub = app.add_subcommand(
      "validate",
      "Read specs of any kind, and the recordings that they name, without running them; report every bad one");
  sub->add_option("SPEC", command->specs, "YAML specs: studies, diagnoses, trials, ...")->required();
  add_set_option(*sub, command->assignments);
  sub->add_flag("--json", command->json, "Print one JSON object on standard output and nothing else");
  sub->footer(
      "Example:\n"
      "  bayesctrl validate configs/*.yaml configs/real/*.yaml");
  sub->callback([command, &exit] {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const std::string& path : command->specs) {
      nlohmann::ordered_json entry{{"file", path}, {"ok", false}};
      try {
        const Node spec = read_spec(path, command->assignments);
        const SpecKind& kind = kind_of(spec);
        entry["kind"] = kind.name;
        const std::string summary = kind.summary(spec);
        entry["ok"] = true;
        entry["summary"] = summary;
        if (!command->json) std::cout << path << ": ok, " << summary << "\n";
      } catch (const Error& error) {
        entry["error"] = error.what();
        if (!command->json) std::cerr << "error: " << error.what() << "\n";
        exit = error.code();
      }
      list.push_back(std::move(entry));
    }
    if (command->json) std::cout << nlohmann::ordered_json{{"specs", list}}.dump(2) << "\n";
  });
}

}  // namespace bayesctrl
