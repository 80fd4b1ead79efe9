#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "inspect/kinds.hpp"
#include "io/files.hpp"

namespace bayesctrl {

void declare_schema(CLI::App& app, ExitCode& /*exit*/) {
  struct Command {
    std::string kind = "study";
    std::string out;
  };
  auto command = std::make_shared<Command>();
  std::vector<std::string> names;
  std::string footer = "Kinds of spec and what reads them:\n";
  for (const SpecKind& kind : spec_kinds()) {
    names.emplace_back(kind.name);
    footer += "  " + std::string(kind.name) + ": " + std::string(kind.text) + "\n";
  }
  CLI::App* sub =
      app.add_subcommand("schema", "Print the JSON Schema of a kind of spec, for editors and other programs");
  sub->add_option("KIND", command->kind, "Kind of spec")->check(one_of(names))->capture_default_str();
  sub->add_option("--out", command->out, "Write the schemas of all kinds into this folder, KIND.json each")
      ->type_name("DIR");
  sub->footer(footer +
              "An editor with the YAML language server checks a spec whose first line is\n"
              "  # yaml-language-server: $schema=schema/study.json");
  sub->callback([command] {
    if (command->out.empty()) {
      std::cout << find_kind(command->kind)->schema().dump(2) << "\n";
      return;
    }
    FileBatch batch;
    for (const SpecKind& kind : spec_kinds()) {
      batch.add(command->out + "/" + std::string(kind.name) + ".json", kind.schema().dump(2) + "\n");
    }
    batch.commit();
  });
}

}  // namespace bayesctrl
