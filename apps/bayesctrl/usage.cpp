#include "usage.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

/// "TEXT:{a,b}" names its choices in braces.
std::vector<std::string> choices_of(const std::string& type) {
  const std::size_t open = type.find('{'), close = type.find('}');
  if (open == std::string::npos || close == std::string::npos) return {};
  return CLI::detail::split(type.substr(open + 1, close - open - 1), ',');
}

OptionHelp option_of(const CLI::Option& option) {
  OptionHelp result;
  for (const std::string& name : option.get_snames()) result.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) result.names.push_back("--" + name);
  const std::string type = option.get_type_name();
  result.choices = choices_of(type);
  const bool flag = option.get_items_expected_max() == 0;
  if (!flag) result.value = result.names.empty() ? option.get_name() : type.substr(0, type.find(':'));
  result.text = option.get_description();
  result.default_value = option.get_default_str();
  result.required = option.get_required();
  result.several = option.get_items_expected_max() > 1;
  return result;
}

}  // namespace

CommandHelp command_tree(const CLI::App& app) {
  CommandHelp command{app.get_name(), app.get_description(), app.get_footer(), {}, {}};
  for (const CLI::Option* option : app.get_options()) command.options.push_back(option_of(*option));
  for (const CLI::App* sub : app.get_subcommands([](const CLI::App*) { return true; })) {
    command.subcommands.push_back(command_tree(*sub));
  }
  return command;
}

std::string advice_on_words(const CLI::App& app) {
  for (const CLI::App* chosen : app.get_subcommands()) {
    if (const std::string advice = advice_on_words(*chosen); !advice.empty()) return advice;
  }
  const std::vector<std::string> left = app.remaining(false);
  if (left.empty()) return "";
  const CommandHelp command = command_tree(app);
  const auto option =
      std::find_if(left.begin(), left.end(), [](const std::string& word) { return word.starts_with("-"); });
  std::vector<std::string_view> known;
  if (option != left.end()) {
    for (const OptionHelp& o : command.options) known.insert(known.end(), o.names.begin(), o.names.end());
    return command.name + " has no option '" + *option + "', " +
           suggestion(std::string_view(*option).substr(0, option->find('=')), known);
  }
  if (command.subcommands.empty()) return command.name + " takes no '" + left.front() + "'";
  for (const CommandHelp& sub : command.subcommands) known.push_back(sub.name);
  return "no command '" + left.front() + "', " + suggestion(left.front(), known);
}

}  // namespace bayesctrl
