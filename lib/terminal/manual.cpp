#include "terminal/command_help.hpp"

namespace bayesctrl {

namespace {

/// Text as man(7) shows it: no character is a command.
std::string plain(const std::string& text) {
  std::string result;
  bool line_begins = true;
  for (const char c : text) {
    if (line_begins && (c == '.' || c == '\'')) result += "\\&";
    if (c == '\\') {
      result += "\\e";
    } else {
      result += c == '-' ? std::string("\\-") : std::string(1, c);
    }
    line_begins = c == '\n';
  }
  return result;
}

std::string entry(const OptionHelp& option) {
  std::string head;
  for (const std::string& name : option.names) head += (head.empty() ? "" : ", ") + ("\\fB" + plain(name) + "\\fR");
  if (!option.value.empty()) head += (head.empty() ? "" : " ") + ("\\fI" + plain(option.value) + "\\fR");
  std::string text = plain(option.text);
  std::string choices;
  for (const std::string& choice : option.choices) choices += (choices.empty() ? "" : ", ") + choice;
  if (!choices.empty()) text += "; one of " + plain(choices);
  if (!option.default_value.empty()) text += " (default " + plain(option.default_value) + ")";
  return ".TP\n" + head + "\n" + text + "\n";
}

std::string synopsis(const CommandHelp& command, const std::string& name) {
  std::string text = "\\fB" + plain(name) + "\\fR [\\fIOPTIONS\\fR]";
  for (const OptionHelp& option : command.options) {
    if (!option.names.empty()) continue;
    const std::string value = "\\fI" + plain(option.value) + "\\fR" + (option.several ? " ..." : "");
    text += option.required ? " " + value : " [" + value + "]";
  }
  return text;
}

/// Lines that stay as they are.
std::string verbatim(const std::string& text) { return text.empty() ? "" : ".PP\n.nf\n" + plain(text) + "\n.fi\n"; }

/// A command, then those below it; `above` is what is typed before it.
std::string section(const CommandHelp& command, const std::string& above) {
  const std::string name = above + command.name;
  std::string text = ".SS " + name + "\n" + synopsis(command, name) + "\n.PP\n" + plain(command.text) + ".\n";
  for (const OptionHelp& option : command.options) {
    if (option.names.empty() || option.names.back() != "--help") text += entry(option);
  }
  text += verbatim(command.footer);
  for (const CommandHelp& sub : command.subcommands) text += section(sub, name + " ");
  return text;
}

}  // namespace

std::string manual_page(const CommandHelp& program, const std::string& version) {
  std::string text = ".TH BAYESCTRL 1 \"\" \"bayesctrl " + version + "\" \"User Commands\"\n.SH NAME\n" + program.name +
                     " \\- " + plain(program.text) + "\n.SH SYNOPSIS\n\\fB" + program.name +
                     "\\fR \\fICOMMAND\\fR [\\fIOPTIONS\\fR] [\\fIARGUMENTS\\fR]\n.SH OPTIONS\n";
  for (const OptionHelp& option : program.options) text += entry(option);
  text += ".SH COMMANDS\n";
  for (const CommandHelp& command : program.subcommands) text += section(command, "");
  return text + ".SH EXAMPLES AND EXIT CODES\n" + verbatim(program.footer);
}

}  // namespace bayesctrl
