// Each documented exit code, provoked. A user's mistake is one line on standard error and nothing on standard output.

#include <catch2/catch.hpp>

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

/// A folder with the slide's spec in it, and results below it.
class Desk {
 public:
  Desk() { write_file(spec(), slide_text()); }
  std::string spec() const { return folder_.path() / "slide.yaml"; }
  std::string out() const { return folder_.path() / "out"; }
  const fs::path& path() const { return folder_.path(); }

  /// `run` of the spec with these changes by --set.
  CommandResult run(const std::vector<std::string>& changes, const std::vector<std::string>& options = {}) const {
    std::vector<std::string> arguments{"run", spec(), "--out", out()};
    for (const std::string& change : changes) arguments.insert(arguments.end(), {"--set", change});
    arguments.insert(arguments.end(), options.begin(), options.end());
    return bayesctrl_with(arguments);
  }

 private:
  Folder folder_;
};

void check_mistake(const CommandResult& result, int status, const std::string& message) {
  CHECK(result.status == status);
  CHECK(result.out.empty());
  CHECK(result.err == message);
}

}  // namespace

TEST_CASE("Exit 0: a run that succeeded prints its table and where the results are", "[apps]") {
  const Desk desk;
  const CommandResult result = desk.run({});
  CHECK(result.status == 0);
  CHECK(result.err.empty());
  CHECK_THAT(result.out, Contains("results in " + desk.out() + "/slide"));
  for (const char* controller : {"P1", "oracle", "SP1", "SP2"}) CHECK_THAT(result.out, Contains(controller));
}

TEST_CASE("Exit 2: a wrong usage says what is wrong and where help is", "[apps]") {
  const Desk desk;
  for (const std::vector<std::string>& arguments : {std::vector<std::string>{},
                                                    {"fly"},
                                                    {"run"},
                                                    {"run", desk.spec(), "--jobs", "-1"},
                                                    {"run", desk.spec(), "--seed", "-1"},
                                                    {"run", desk.spec(), "--seed", "1.5"},
                                                    {"run", desk.spec(), "--seed", "18446744073709551616"},
                                                    {"run", desk.spec(), "--progress", "loud"},
                                                    {"table"},
                                                    {"check", desk.out()}}) {
    const CommandResult result = bayesctrl_with(arguments, desk.path());
    INFO(Catch::Detail::stringify(arguments));
    CHECK(result.status == 2);
    CHECK(result.out.empty());
    CHECK_THAT(result.err, Contains("--help"));
  }
  CHECK_FALSE(fs::exists(desk.path() / "results"));
}

TEST_CASE("Exit 3: an unknown path of --set is refused with a suggestion, and nothing runs", "[apps]") {
  const Desk desk;
  check_mistake(desk.run({"controllers.P1.gian=3"}), 3,
                "error: --set controllers.P1.gian=3: proportional has no 'gian', did you mean 'gain'?\n");
  check_mistake(desk.run({"contrllers.P1.gain=3"}), 3,
                "error: --set contrllers.P1.gain=3: study has no 'contrllers', did you mean 'controllers'?\n");
  check_mistake(desk.run({"controllers.SP3.type=adaptive", "controllers.SP22.trained_from=SP1"}), 3,
                "error: --set controllers.SP22.trained_from=SP1: controllers has no 'SP22', did you mean 'SP2'?\n");
  check_mistake(desk.run({"duration"}), 3, "error: --set duration: has no '=', write path=value\n");
  CHECK_FALSE(fs::exists(desk.out()));
}

TEST_CASE("Exit 3: bad specs and bad data are located in their file", "[apps]") {
  const Desk desk;
  const std::string bad = desk.path() / "bad.yaml", csv = desk.path() / "table.csv";
  write_file(bad, "name: bad\nmodel: {plant: pendulm}\n");
  check_mistake(bayesctrl_with({"run", bad, "--out", desk.out()}), 3,
                "error: " + bad + ":2:16: plant = 'pendulm', did you mean 'pendulum'?\n");
  write_file(csv, "a,b\n1\n");
  check_mistake(bayesctrl_with({"table", csv}), 3, "error: " + csv + ":2: has 1 cells, the header 2\n");
  write_file(csv, "t,u\n1,0\n1,0\n");
  check_mistake(bayesctrl_with({"simulate", desk.spec(), "--input", csv}), 3,
                "error: " + csv + ":3: t does not increase\n");
}

TEST_CASE("Exit 3: two specs of one name are refused, because their results would overwrite each other", "[apps]") {
  const Desk desk;
  const std::string other = desk.path() / "other.yaml";
  write_file(other, slide_text());
  check_mistake(
      bayesctrl_with({"run", desk.spec(), other, "--out", desk.out()}), 3,
      "error: " + other + ": has the name 'slide' of " + desk.spec() + ": their results would overwrite each other\n");
  CHECK_FALSE(fs::exists(desk.out()));
}

TEST_CASE("Exit 4: a study of which every run fails, and a machine that diverges under its input", "[apps]") {
  const Desk desk;
  std::vector<std::string> changes = unstable();
  changes.push_back("controllers={oracle: {type: oracle}}");
  const CommandResult result = desk.run(changes);
  CHECK(result.status == 4);
  CHECK_THAT(result.out,
             Contains("the state diverges at t = ") && Contains("1 of 1 runs failed; the column 'reason' says why"));
  write_file(desk.path() / "u.csv", "t,u\n0,1e308\n1,1e308\n");
  const CommandResult free = bayesctrl_with(
      {"simulate", desk.spec(), "--set", "model.parameters.mass=1e-3", "--input", (desk.path() / "u.csv").string()});
  CHECK(free.status == 4);
  CHECK(free.out.empty());
  CHECK_THAT(free.err, Catch::StartsWith("error: the state diverges at t = "));
}

TEST_CASE("Exit 5: of several runs some failed, and the rows of both kinds are written", "[apps]") {
  const Desk desk;
  for (const std::vector<std::string>& changes : {unstable(), uninvertible()}) {
    const CommandResult result = desk.run(changes);
    CHECK(result.status == 5);
    CHECK_THAT(result.out, Contains("of 4 runs failed; the column 'reason' says why"));
    const Table table = read_csv(fs::path(desk.out()) / "slide" / "table.csv");
    REQUIRE(table.rows() == 4);
    for (std::size_t row = 0; row < 4; ++row) {
      const bool failed = column_texts(table, "status")[row] == "failed";
      CHECK(failed != column_texts(table, "reason")[row].empty());
    }
    CHECK(column_texts(table, "status")[0] == "ok");
  }
}

TEST_CASE("Exit 6: a file that is not there", "[apps]") {
  check_mistake(bayesctrl_with({"run", "nowhere.yaml"}), 6, "error: nowhere.yaml: No such file or directory\n");
  check_mistake(bayesctrl_with({"table", "nowhere"}), 6, "error: nowhere: No such file or directory\n");
  check_mistake(bayesctrl_with({"check", "nowhere", "--against", "nothing.yaml"}), 6,
                "error: nothing.yaml: No such file or directory\n");
  check_mistake(bayesctrl_with({"calibrate", "nowhere.yaml"}), 6, "error: nowhere.yaml: No such file or directory\n");
}

TEST_CASE("Exit 6: an output folder that cannot be made ends with its path, and leaves nothing half-written",
          "[apps]") {
  const Desk desk;
  write_file(desk.out(), "a regular file");
  const CommandResult result = desk.run({});
  CHECK(result.status == 6);
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Catch::Matches("error: " + desk.out() + "/slide/.*: Not a directory\n"));
  CHECK(files_below(desk.path()) ==
        std::map<std::string, std::string>{{"out", "a regular file"}, {"slide.yaml", slide_text()}});
}

TEST_CASE("Exit 6: a full standard output is noticed", "[apps]") {
  const CommandResult result = run_command({"/bin/sh", "-c", "exec " BAYESCTRL_BINARY " list >/dev/full"});
  CHECK(result.status == 6);
  CHECK(result.err == "error: cannot write to standard output\n");
}
