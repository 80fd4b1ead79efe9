#include <CLI/CLI.hpp>

#include "commands.hpp"

namespace bayesctrl {

void add_set_option(CLI::App& command, std::vector<std::string>& assignments) {
  command
      .add_option("--set", assignments,
                  "Override one setting of every SPEC: path=value, e.g. controllers.P1.gain=10; the value is YAML")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
}

void add_json_option(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print one JSON object on standard output and nothing else");
}

void add_loudness(CLI::App& command, Loudness& loudness) {
  command
      .add_option("--progress", loudness.progress,
                  "How progress is shown on standard error; default: a bar on a "
                  "terminal, else a line now and then")
      ->check(one_of({"none", "bar", "text"}));
  command.add_flag("--quiet", loudness.quiet, "Print nothing but errors and what goes into no file");
  add_json_option(command, loudness.json);
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "{" : ",") + word;
  return {[words](std::string& given) -> std::string {
            const std::vector<std::string_view> known(words.begin(), words.end());
            if (std::find(known.begin(), known.end(), given) != known.end()) return "";
            return "'" + given + "', " + suggestion(given, known);
          },
          list + "}", "one_of"};
}

Node read_spec(const std::string& path, const std::vector<std::string>& assignments) {
  Node spec = read_yaml(path);
  for (const std::string& assignment : assignments) set_path(spec, assignment);
  return spec;
}

}  // namespace bayesctrl
