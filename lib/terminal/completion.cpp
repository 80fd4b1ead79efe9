#include <algorithm>
#include <stdexcept>

#include "terminal/command_help.hpp"

namespace bayesctrl {

namespace {

std::string joined(const std::vector<std::string>& words, const std::string& between = " ") {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : between) + word;
  return text;
}

/// In single quotes, as bash, zsh and fish read them.
std::string quoted(const std::string& text, const std::string& quote) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? quote : std::string(1, c);
  return result + "'";
}

std::vector<std::string> names_of(const CommandHelp& command) {
  std::vector<std::string> names;
  for (const OptionHelp& option : command.options) names.insert(names.end(), option.names.begin(), option.names.end());
  return names;
}

std::vector<std::string> subcommands_of(const CommandHelp& program) {
  std::vector<std::string> names;
  for (const CommandHelp& command : program.subcommands) names.push_back(command.name);
  return names;
}

/// Positional arguments of a command; completion offers what any of them may be.
std::vector<OptionHelp> positionals(const CommandHelp& command) {
  std::vector<OptionHelp> list;
  std::copy_if(command.options.begin(), command.options.end(), std::back_inserter(list),
               [](const OptionHelp& option) { return option.names.empty(); });
  return list;
}

/// A command without subcommands: theirs become choices of its first argument, and their options its own.
CommandHelp flattened(const CommandHelp& command) {
  CommandHelp flat = command;
  if (command.subcommands.empty()) return flat;
  flat.options.push_back({{}, "COMMAND", "", "", subcommands_of(command), true, false});
  for (const CommandHelp& sub : command.subcommands) {
    for (const OptionHelp& option : sub.options) {
      const bool known = std::any_of(flat.options.begin(), flat.options.end(),
                                     [&](const OptionHelp& o) { return !o.names.empty() && o.names == option.names; });
      if (!known) flat.options.push_back(option);
    }
  }
  return flat;
}

std::vector<CommandHelp> commands_of(const CommandHelp& program) {
  std::vector<CommandHelp> list;
  for (const CommandHelp& command : program.subcommands) list.push_back(flattened(command));
  return list;
}

// --- bash ---

std::string bash_action(const OptionHelp& option) {
  switch (kind_of_value(option)) {
    case ValueKind::choice:
      return "_bayesctrl_words \"" + joined(option.choices) + "\"";
    case ValueKind::file:
      return "_bayesctrl_files";
    case ValueKind::folder:
      return "_bayesctrl_folders";
    case ValueKind::spec:
      return "_bayesctrl_specs";
    case ValueKind::word:
      break;
  }
  return ":";
}

constexpr const char* kBashHead = R"(# bash completion of bayesctrl, written by: bayesctrl completion bash
_bayesctrl_words() { mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen -W "$1" -- "$cur"); }
_bayesctrl_from() { compopt -o filenames 2>/dev/null; mapfile -t -O "${#COMPREPLY[@]}" COMPREPLY < <(compgen "$@" -- "$cur"); }
_bayesctrl_files() { _bayesctrl_from -f; }
_bayesctrl_folders() { _bayesctrl_from -d; }
_bayesctrl_specs() { _bayesctrl_from -d; _bayesctrl_from -f -X '!*.yaml'; _bayesctrl_from -f -X '!*.yml'; }
_bayesctrl() {
  local cur="${COMP_WORDS[COMP_CWORD]}" before="${COMP_WORDS[COMP_CWORD-1]}" command="${COMP_WORDS[1]}"
  COMPREPLY=()
)";

std::string bash(const CommandHelp& program) {
  std::string text = kBashHead;
  text += "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n    _bayesctrl_words \"" + joined(subcommands_of(program)) + " " +
          joined(names_of(program)) + "\"\n    return\n  fi\n  case \"$command $before\" in\n";
  for (const CommandHelp& command : commands_of(program)) {
    for (const OptionHelp& option : command.options) {
      if (option.names.empty() || option.value.empty()) continue;
      std::vector<std::string> patterns;
      for (const std::string& name : option.names) patterns.push_back("\"" + command.name + " " + name + "\"");
      text += "    " + joined(patterns, " | ") + ") " + bash_action(option) + "; return ;;\n";
    }
  }
  text += "  esac\n  case \"$command $COMP_CWORD\" in\n";
  for (const CommandHelp& command : program.subcommands) {
    if (command.subcommands.empty()) continue;
    text += "    \"" + command.name + " 2\") _bayesctrl_words \"" + joined(subcommands_of(command)) + "\"; return ;;\n";
  }
  text += "  esac\n  case \"$command\" in\n";
  for (const CommandHelp& command : commands_of(program)) {
    text += "    " + command.name + ")\n      case \"$cur\" in\n        -*) _bayesctrl_words \"" +
            joined(names_of(command)) + "\" ;;\n        *) ";
    std::vector<std::string> actions;
    for (const OptionHelp& option : positionals(command)) actions.push_back(bash_action(option));
    text += (actions.empty() ? ":" : joined(actions, "; ")) + " ;;\n      esac ;;\n";
  }
  return text + "  esac\n}\ncomplete -F _bayesctrl bayesctrl\n";
}

// --- zsh ---

/// Text inside the brackets of an _arguments specification.
std::string zsh_text(std::string text) {
  std::replace(text.begin(), text.end(), '[', '(');
  std::replace(text.begin(), text.end(), ']', ')');
  return text;
}

std::string zsh_value(const OptionHelp& option) {
  if (option.value.empty()) return "";
  const std::string name = ":" + option.value + ":";
  switch (kind_of_value(option)) {
    case ValueKind::choice:
      return name + "(" + joined(option.choices) + ")";
    case ValueKind::file:
      return name + "_files";
    case ValueKind::folder:
      return name + "_files -/";
    case ValueKind::spec:
      return name + "_files -g \"*.(yaml|yml)\"";
    case ValueKind::word:
      break;
  }
  return name;
}

std::string zsh(const CommandHelp& program) {
  const auto entry = [](const std::string& text) { return " \\\n        " + quoted(text, "'\\''"); };
  std::string text =
      "#compdef bayesctrl\n# zsh completion of bayesctrl, written by: bayesctrl completion zsh\n_bayesctrl() {\n"
      "  local -a commands\n  commands=(\n";
  for (const CommandHelp& command : commands_of(program)) {
    text += "    " + quoted(command.name + ":" + command.text, "'\\''") + "\n";
  }
  text +=
      "  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    return\n  fi\n"
      "  shift words\n  (( CURRENT-- ))\n  case $words[1] in\n";
  for (const CommandHelp& command : commands_of(program)) {
    text += "    " + command.name + ")\n      _arguments";
    for (const OptionHelp& option : command.options) {
      for (const std::string& name : option.names) {
        text += entry((option.several ? "*" : "") + name + "[" + zsh_text(option.text) + "]" + zsh_value(option));
      }
      if (option.names.empty()) text += entry((option.several ? "*" : "") + zsh_value(option));
    }
    text += "\n      ;;\n";
  }
  return text +
         "  esac\n}\nif [ \"$funcstack[1]\" = _bayesctrl ]; then _bayesctrl \"$@\"; else compdef _bayesctrl bayesctrl; "
         "fi\n";
}

// --- fish ---

std::string fish_value(const OptionHelp& option) {
  switch (kind_of_value(option)) {
    case ValueKind::choice:
      return " -x -a " + quoted(joined(option.choices), "\\'");
    case ValueKind::file:
      return " -r -F";
    case ValueKind::folder:
      return " -x -a '(__fish_complete_directories)'";
    case ValueKind::spec:
      return " -x -a '(__fish_complete_suffix .yaml)'";
    case ValueKind::word:
      break;
  }
  return option.value.empty() ? "" : " -x";
}

std::string fish(const CommandHelp& program) {
  std::string text =
      "# fish completion of bayesctrl, written by: bayesctrl completion fish\ncomplete -c bayesctrl -f\n";
  for (const CommandHelp& command : commands_of(program)) {
    text += "complete -c bayesctrl -n __fish_use_subcommand -a " + command.name + " -d " + quoted(command.text, "\\'") +
            "\n";
    for (const OptionHelp& option : command.options) {
      text += "complete -c bayesctrl -n '__fish_seen_subcommand_from " + command.name + "'";
      for (const std::string& name : option.names)
        text += name[1] == '-' ? " -l " + name.substr(2) : " -s " + name.substr(1);
      text += fish_value(option);
      if (!option.names.empty()) text += " -d " + quoted(option.text, "\\'");
      text += "\n";
    }
  }
  return text;
}

}  // namespace

ValueKind kind_of_value(const OptionHelp& option) {
  if (!option.choices.empty()) return ValueKind::choice;
  if (option.value == "SPEC") return ValueKind::spec;
  if (option.value == "DIR") return ValueKind::folder;
  if (option.value == "FILE" || option.value == "PREFIX") return ValueKind::file;
  return ValueKind::word;
}

std::string completion_script(const CommandHelp& program, const std::string& shell) {
  if (shell == "bash") return bash(program);
  if (shell == "zsh") return zsh(program);
  if (shell == "fish") return fish(program);
  throw std::invalid_argument("no completion for the shell '" + shell + "'");
}

}  // namespace bayesctrl
