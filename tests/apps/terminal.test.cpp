// What stands on a terminal: plots, one JSON object, differences, completion and the manual page.

#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <sstream>

#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

/// Two results of the slide, of which one has another gain.
class Two {
 public:
  Two() {
    write_file(spec(), slide_text());
    for (const std::string gain : {"1", "2"}) {
      REQUIRE(bayesctrl_with({"run", spec(), "--set", "controllers.P1.gain=" + gain, "--out", path(gain), "--quiet"})
                  .status == 0);
    }
  }
  std::string path(const std::string& name) const { return folder_.path() / name; }
  std::string spec() const { return path("slide.yaml"); }
  CommandResult diff(const std::vector<std::string>& options, const std::string& other = "2/slide") const {
    std::vector<std::string> arguments{"diff", path("1/slide"), path(other)};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return bayesctrl_with(arguments);
  }

 private:
  Folder folder_;
};

/// The words that bash would offer.
std::vector<std::string> completed(const Folder& folder, const std::string& words) {
  const std::string script = folder.path() / "completion.bash";
  write_file(script, bayesctrl_with({"completion", "bash"}).out);
  const CommandResult result = run_command({"bash", "-c",
                                            "source '" + script + "'; COMP_WORDS=(" + words +
                                                "); COMP_CWORD=$((${#COMP_WORDS[@]} - 1)); COMPREPLY=(); "
                                                "_bayesctrl; printf '%s\\n' \"${COMPREPLY[@]}\""},
                                           folder.path());
  INFO(result.err);
  CHECK(result.status == 0);
  std::vector<std::string> list;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) {
    if (!line.empty()) list.push_back(line);
  }
  return list;
}

bool installed(const std::string& program) { return run_command({"sh", "-c", "command -v " + program}).status == 0; }

}  // namespace

TEST_CASE("diff says which settings and metrics are not the same, in each format", "[apps]") {
  const Two two;
  const CommandResult text = two.diff({});
  CHECK(text.status == 0);
  CHECK_THAT(text.out, Contains("controllers.P1.gain") && Contains("P1.energy") && Contains("%"));
  CHECK_THAT(text.out, !Contains("oracle"));
  CHECK_THAT(two.diff({"--format", "markdown"}).out, Contains("| controllers.P1.gain | 1 | 2 |"));
  const Table csv = parse_csv(two.diff({"--format", "csv"}).out, "diff");
  CHECK(column_texts(csv, "kind").front() == "setting");
  CHECK(column_texts(csv, "kind").back() == "metric");
  const auto json = nlohmann::json::parse(two.diff({"--json"}).out);
  CHECK(json["differ"] == true);
  CHECK(json["settings"].size() == 1);
  CHECK(json == nlohmann::json::parse(two.diff({"--format", "json"}).out));
}

TEST_CASE("diff --exit-code is 1 where there is a difference and 0 where there is none", "[apps]") {
  const Two two;
  CHECK(two.diff({"--exit-code"}).status == 1);
  CHECK(two.diff({"--exit-code"}, "1/slide").status == 0);
  CHECK(two.diff({}, "1/slide").out == "no difference\n");
  CHECK(two.diff({}, "nowhere").status == 6);
  CHECK(bayesctrl_with({"diff", two.path("1/slide")}).status == 2);
}

TEST_CASE("A run with --plot draws every controller's position and input, without colour where there is no terminal",
          "[apps]") {
  const Two two;
  const CommandResult plain = bayesctrl_with({"run", two.spec(), "--out", two.path("p"), "--plot"});
  CHECK(plain.status == 0);
  for (const char* controller : {"P1", "oracle", "SP1", "SP2"}) {
    CHECK_THAT(plain.out, Contains("slide, " + std::string(controller) + "\n          q [m]"));
  }
  CHECK_THAT(plain.out, !Contains("\033"));
  const CommandResult json = bayesctrl_with({"run", two.spec(), "--out", two.path("p"), "--plot", "--json"});
  CHECK(nlohmann::json::parse(json.out)["ok"] == 4);
  const CommandResult free = bayesctrl_with({"simulate", two.spec(), "--plot"});
  CHECK_THAT(free.err, Contains("q [m]"));
  CHECK(parse_csv(free.out, "out").rows() == 201);  // the table alone
}

TEST_CASE("On a terminal plots are coloured and a bar is drawn, unless NO_COLOR and --progress say otherwise",
          "[apps][slow]") {
  if (!installed("script")) return;
  const Two two;
  const auto on_terminal = [&](const std::string& environment, const std::string& options) {
    const std::string line = environment + " " BAYESCTRL_BINARY " run " + two.spec() + " --out " + two.path("t") +
                             " --jobs 1 --set 'sweep={seed: [1, 2, 3, 4]}' --set duration=200 " + options;
    const CommandResult result = run_command({"script", "-qec", line, "/dev/null"});
    CHECK(result.status == 0);
    return result.out;
  };
  const std::string terminal = "TERM=xterm NO_COLOR=";
  CHECK_THAT(on_terminal(terminal, "--plot"), Contains("\033[36m") && Contains("#") && Contains("left"));
  CHECK_THAT(on_terminal(terminal + "1", "--plot"), !Contains("\033[36m") && !Contains("\033[32m") && Contains("left"));
  CHECK_THAT(on_terminal(terminal, "--progress none"), !Contains("left") && !Contains("\033"));
  CHECK(on_terminal(terminal, "--quiet").empty());
  CHECK_THAT(on_terminal("TERM=dumb NO_COLOR=", "--plot"), !Contains("\033"));
}

TEST_CASE("Every command with --json prints one JSON object and nothing else", "[apps]") {
  const Two two;
  write_file(
      two.path("published.yaml"),
      "name: T\nsource: s\ncells: [{experiment: slide, controller: P1, metric: energy, value: -1, absolute: 0}]\n");
  const std::string results = two.path("1/slide"), published = two.path("published.yaml");
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{"list"},
                                                    {"list", "kernels"},
                                                    {"validate", two.spec()},
                                                    {"validate", "nowhere.yaml"},
                                                    {"table", results},
                                                    {"table", results, "--against", published},
                                                    {"check", results, "--against", published},
                                                    {"diff", results, results},
                                                    {"run", two.spec(), "--out", two.path("o")}}) {
    INFO(Catch::Detail::stringify(arguments));
    std::vector<std::string> with = arguments;
    with.push_back("--json");
    const CommandResult result = bayesctrl_with(with);
    CHECK(result.err.empty());
    CHECK(nlohmann::json::parse(result.out).is_object());
  }
}

TEST_CASE("check writes its whole table although a cell is violated", "[apps]") {
  const Two two;
  write_file(
      two.path("published.yaml"),
      "name: T\nsource: s\ncells:\n  - {experiment: slide, controller: P1, metric: energy, value: -1, absolute: 0}\n"
      "  - {experiment: slide, controller: oracle, metric: energy, value: -2, relative: 0.1}\n"
      "  - {experiment: slide, controller: SP1, metric: energy, value: 0, absolute: 1e9}\n");
  const CommandResult result = bayesctrl_with(
      {"check", two.path("1/slide"), "--against", two.path("published.yaml"), "--out", two.path("checked")});
  CHECK(result.status == 1);
  CHECK_THAT(result.out, Contains("violated: slide P1 energy") && Contains("violated: slide oracle energy") &&
                             Contains("T: 1 of 3 cells hold"));
  for (const char* format : {"csv", "md", "json"}) CHECK(fs::exists(two.path("checked.") + format));
  CHECK(read_csv(two.path("checked.csv")).rows() == 3);
}

TEST_CASE("bash completes commands, options, choices and files", "[apps]") {
  const Folder folder;
  for (const char* name : {"one.yaml", "two.yml", "three.csv"}) write_file(folder.path() / name, "");
  fs::create_directory(folder.path() / "results dir");
  using Words = std::vector<std::string>;
  CHECK(completed(folder, "bayesctrl ru") == Words{"run"});
  CHECK(completed(folder, "bayesctrl d") == Words{"diff", "diagnose"});
  CHECK(completed(folder, "bayesctrl run --pro") == Words{"--progress"});
  CHECK(completed(folder, "bayesctrl run --progress ''") == Words{"none", "bar", "text"});
  CHECK(completed(folder, "bayesctrl run ''") == Words{"results dir", "one.yaml", "two.yml"});
  CHECK(completed(folder, "bayesctrl run --out ''") == Words{"results dir"});
  CHECK(completed(folder, "bayesctrl list ker") == Words{"kernels"});
  CHECK(completed(folder, "bayesctrl init ''") == Words{"experiment", "diagnosis"});
  CHECK(completed(folder, "bayesctrl init diagnosis --plant pen") == Words{"pendulum"});
  CHECK(completed(folder, "bayesctrl simulate --input th") == Words{"three.csv"});
  CHECK(completed(folder, "bayesctrl table re") == Words{"results dir"});
}

TEST_CASE("The completions are scripts that their shells read", "[apps]") {
  const Folder folder;
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const CommandResult result = bayesctrl_with({"completion", shell});
    CHECK(result.status == 0);
    CHECK_THAT(result.out, Contains("--progress") || Contains("-l progress"));
    const std::string script = folder.path() / shell;
    write_file(script, result.out);
    if (!installed(shell)) {
      WARN(std::string(shell) + " is not installed: its completion is not read");
      continue;
    }
    const CommandResult read = run_command({shell, "-n", script});
    INFO(read.err);
    CHECK(read.status == 0);
  }
}

TEST_CASE("The manual page has every command and option, and no line that man does not understand", "[apps]") {
  const Folder folder;
  const CommandResult result = bayesctrl_with({"man"});
  CHECK(result.status == 0);
  const std::string& page = result.out;
  for (const char* section :
       {".SH NAME", ".SH SYNOPSIS", ".SS run\n", ".SS init diagnosis\n", ".SS diff\n", "\\-\\-exit\\-code"}) {
    CHECK_THAT(page, Contains(section));
  }
  std::istringstream lines(page);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with(".")) continue;
    INFO(line);
    const std::string request = line.substr(0, line.find(' '));
    CHECK((request == ".TH" || request == ".SH" || request == ".SS" || request == ".TP" || request == ".PP" ||
           request == ".nf" || request == ".fi"));
  }
  if (!installed("groff")) return;
  write_file(folder.path() / "page", page);
  CHECK(run_command({"groff", "-man", "-Tutf8", "-ww", folder.path() / "page"}).err.empty());
}
