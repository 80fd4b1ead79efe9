#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"

namespace CLI {
class App;
}

namespace bayesctrl {

/// Each subcommand declares its options and leaves its result in `exit`. A new subcommand is one file and one line in
/// main.cpp.
void declare_run(CLI::App& app, ExitCode& exit);
void declare_validate(CLI::App& app, ExitCode& exit);
void declare_list(CLI::App& app, ExitCode& exit);
void declare_table(CLI::App& app, ExitCode& exit);
void declare_check(CLI::App& app, ExitCode& exit);
void declare_simulate(CLI::App& app, ExitCode& exit);
void declare_calibrate(CLI::App& app, ExitCode& exit);
void declare_diagnose(CLI::App& app, ExitCode& exit);
void declare_trial(CLI::App& app, ExitCode& exit);
void declare_report(CLI::App& app, ExitCode& exit);

/// Options that several subcommands share.
void add_set_option(CLI::App& command, std::vector<std::string>& assignments);

/// True from the first Ctrl-C (SIGINT) or SIGTERM on; the handlers are set by main.
bool interrupted();

/// From here on a signal ends the program at once: for work that writes nothing before its end.
void end_at_once();

}  // namespace bayesctrl
