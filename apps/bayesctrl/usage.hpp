#pragma once

#include <string>

#include "terminal/command_help.hpp"

namespace CLI {
class App;
}

namespace bayesctrl {

/// The commands and options of `app` as a plain value.
CommandHelp command_tree(const CLI::App& app);

/// What was meant by the first word that no command or option takes; empty when all are taken.
std::string advice_on_words(const CLI::App& app);

}  // namespace bayesctrl
