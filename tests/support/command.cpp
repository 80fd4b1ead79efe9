#include "support/command.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>

#include <csignal>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace bayesctrl::testing {

namespace {

std::string whole(const std::filesystem::path& path) {
  std::ostringstream text;
  text << std::ifstream(path, std::ios::binary).rdbuf();
  return text.str();
}

}  // namespace

Command::Command(const std::vector<std::string>& arguments, const std::filesystem::path& working_folder) {
  std::vector<char*> argv;
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  const std::string out = capture_.path() / "out", err = capture_.path() / "err";
  constexpr int kWrite = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  ::posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, out.c_str(), kWrite, 0600);
  ::posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, err.c_str(), kWrite, 0600);
  if (!working_folder.empty()) ::posix_spawn_file_actions_addchdir_np(&actions, working_folder.c_str());
  const int error = ::posix_spawnp(&process_, argv[0], &actions, nullptr, argv.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  if (error != 0) throw std::runtime_error("cannot run " + arguments.front());
}

Command::~Command() {
  if (process_ < 0) return;
  ::kill(process_, SIGKILL);
  ::waitpid(process_, nullptr, 0);
}

void Command::interrupt() const { signal(SIGINT); }

void Command::signal(int number) const { ::kill(process_, number); }

CommandResult Command::wait() {
  int status = 0;
  ::waitpid(process_, &status, 0);
  process_ = -1;
  return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), whole(capture_.path() / "out"),
          whole(capture_.path() / "err")};
}

CommandResult run_command(const std::vector<std::string>& arguments, const std::filesystem::path& working_folder) {
  return Command(arguments, working_folder).wait();
}

CommandResult bayesctrl_with(std::vector<std::string> arguments, const std::filesystem::path& working_folder) {
  arguments.insert(arguments.begin(), BAYESCTRL_BINARY);
  return run_command(arguments, working_folder);
}

}  // namespace bayesctrl::testing
