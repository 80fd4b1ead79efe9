#pragma once

#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/fields.hpp"
#include "io/node.hpp"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace bayesctrl {

/// Each subcommand declares its options and leaves its result in `exit`. A new subcommand is one file and one line in
/// main.cpp.
void declare_run(CLI::App& app, ExitCode& exit);
void declare_validate(CLI::App& app, ExitCode& exit);
void declare_show(CLI::App& app, ExitCode& exit);
void declare_init(CLI::App& app, ExitCode& exit);
void declare_schema(CLI::App& app, ExitCode& exit);
void declare_list(CLI::App& app, ExitCode& exit);
void declare_table(CLI::App& app, ExitCode& exit);
void declare_check(CLI::App& app, ExitCode& exit);
void declare_diff(CLI::App& app, ExitCode& exit);
void declare_simulate(CLI::App& app, ExitCode& exit);
void declare_calibrate(CLI::App& app, ExitCode& exit);
void declare_diagnose(CLI::App& app, ExitCode& exit);
void declare_sweep(CLI::App& app, ExitCode& exit);
void declare_sensitivity(CLI::App& app, ExitCode& exit);
void declare_trial(CLI::App& app, ExitCode& exit);
void declare_bench(CLI::App& app, ExitCode& exit);
void declare_report(CLI::App& app, ExitCode& exit);
void declare_completion(CLI::App& app, ExitCode& exit);
void declare_man(CLI::App& app, ExitCode& exit);

/// Options that several subcommands share.
void add_set_option(CLI::App& command, std::vector<std::string>& assignments);
void add_jobs_option(CLI::App& command, int& jobs);

/// What is said, and how. `quiet` and `json` both mean no progress.
struct Loudness {
  std::string progress;  // "none", "bar", "text", or empty: what fits the terminal
  bool quiet = false;
  bool json = false;
};
void add_loudness(CLI::App& command, Loudness& loudness);
void add_json_option(CLI::App& command, bool& json);
void add_format_option(CLI::App& command, std::string& format);  // "text", "md" or "markdown", "csv", "json"

/// Significant digits of numbers in tables on the terminal.
inline constexpr int kShownDigits = 6;

/// Numbers of threads or processes beyond this are mistakes.
inline constexpr int kMostJobs = 4096;

/// A seed, which CLI11 itself would take from -1 as well, as 2^64 - 1.
CLI::Validator seed_check();

/// A number within a range, which CLI11 itself would take from nan.
CLI::Validator number_check(const Range& range);

/// Checks that a word is one of these, with "did you mean"; --help and the shell completion show them.
CLI::Validator one_of(const std::vector<std::string>& words);

/// A spec with the assignments of --set, of one kind ("study", inspect/kinds.hpp) or of any. Throws SpecError or
/// IoError.
Node read_spec(const std::string& path, const std::vector<std::string>& assignments, std::string_view kind = {});

/// True from the first Ctrl-C (SIGINT) or SIGTERM on; the handlers are set by main.
bool interrupted();

/// From here on a signal ends the program at once: for work that writes nothing before its end. `advice`, which must
/// outlive the program, is what is said then.
void end_at_once(const char* advice);

/// From here on freed memory stays with the program: fits, searches and sweeps ask for the same megabytes again and
/// again, and mapped and unmapped each time, their pages would take as long as a sixth of the work.
void keep_memory();

}  // namespace bayesctrl
