#include <CLI/CLI.hpp>

#include "commands.hpp"
#include "inspect/kinds.hpp"
#include "io/text.hpp"

namespace bayesctrl {

void add_set_option(CLI::App& command, std::vector<std::string>& assignments) {
  command
      .add_option("--set", assignments,
                  "Override one setting of every SPEC: path=value, e.g. controllers.P1.gain=10; the value is YAML")
      ->type_name("PATH=VALUE")
      ->allow_extra_args(false);
}

void add_jobs_option(CLI::App& command, int& jobs) {
  command.add_option("-j,--jobs", jobs, "Threads; 0: all cores. Results do not depend on it")
      ->check(CLI::Range(0, kMostJobs))
      ->capture_default_str();
}

void add_json_option(CLI::App& command, bool& json) {
  command.add_flag("--json", json, "Print one JSON object on standard output and nothing else");
}

void add_format_option(CLI::App& command, std::string& format) {
  command.add_option("--format", format, "What is printed")
      ->check(one_of({"text", "md", "markdown", "csv", "json"}))
      ->capture_default_str();
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

CLI::Validator seed_check() {
  return {[](std::string& text) -> std::string {
            return parse_integer<std::uint64_t>(text) ? "" : text + " is no whole number from 0 to 2^64 - 1";
          },
          "", "seed"};
}

CLI::Validator number_check(const Range& range) {
  return {[range](std::string& text) -> std::string {
            const std::optional<double> number = parse_double(text);
            return number && range.contains(*number) ? "" : text + " is not " + to_string(range);
          },
          "", "number"};
}

Node read_spec(const std::string& path, const std::vector<std::string>& assignments, std::string_view kind) {
  Node spec = read_yaml(path);
  if (!kind.empty()) require_kind(spec, kind);
  for (const std::string& assignment : assignments) set_path(spec, assignment);
  return spec;
}

}  // namespace bayesctrl
