#include "report/report.hpp"

#include <CLI/CLI.hpp>
#include <iostream>
#include <memory>

#include "commands.hpp"

namespace bayesctrl {

void declare_report(CLI::App& app, ExitCode& /*exit*/) {
  auto folders = std::make_shared<std::vector<std::string>>();
  CLI::App* sub = app.add_subcommand("report", "Write report.html for results of a diagnosis or a trial, to look at");
  sub->add_option("DIR", *folders, "Folders that diagnose or trial wrote")->required();
  sub->callback([folders] {
    for (const std::string& folder : *folders) {
      write_report(folder);
      std::cout << "written: " << (std::filesystem::path(folder) / "report.html").string() << "\n";
    }
  });
}

}  // namespace bayesctrl
