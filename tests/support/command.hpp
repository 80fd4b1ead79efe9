#pragma once

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <vector>

#include "io/folder.hpp"

namespace bayesctrl::testing {

struct CommandResult {
  int status = 0;  // as a shell has it: the exit code, or 128 + the signal that ended it
  std::string out;
  std::string err;
};

/// A running program whose output is captured. No shell is involved: arguments arrive as they are.
class Command {
 public:
  explicit Command(const std::vector<std::string>& arguments, const std::filesystem::path& working_folder = "");
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;
  ~Command();  // ends the program if it still runs

  void interrupt() const;  // as Ctrl-C does
  void signal(int number) const;
  CommandResult wait();

 private:
  io_examples::Folder capture_;
  pid_t process_ = -1;
};

/// Runs a program to its end.
CommandResult run_command(const std::vector<std::string>& arguments, const std::filesystem::path& working_folder = "");

/// Runs the program under test.
CommandResult bayesctrl_with(std::vector<std::string> arguments, const std::filesystem::path& working_folder = "");

}  // namespace bayesctrl::testing
