#pragma once

#include <string>
#include <vector>

namespace bayesctrl {

/// An option of a command, or where `names` is empty a positional argument.
struct OptionHelp {
  std::vector<std::string> names;  // "-j", "--jobs"
  std::string value;               // "DIR"; empty for a flag
  std::string text;
  std::string default_value;
  std::vector<std::string> choices;  // empty: any value
  bool required = false;
  bool several = false;  // takes several values
};

/// A command of the program as its --help has it.
struct CommandHelp {
  std::string name;
  std::string text;
  std::string footer;
  std::vector<OptionHelp> options;
  std::vector<CommandHelp> subcommands;
};

/// What a value's name says of the files that it may be.
enum class ValueKind { word, choice, file, folder, spec };
ValueKind kind_of_value(const OptionHelp& option);

/// A script that completes subcommands, options, choices and file names in bash, zsh or fish; to be sourced. Throws
/// std::invalid_argument for another shell.
std::string completion_script(const CommandHelp& program, const std::string& shell);

/// A manual page (section 1) in the notation of man(7).
std::string manual_page(const CommandHelp& program, const std::string& version);

}  // namespace bayesctrl
