// Faults that were found by attack, each as its user meets it: a clear line, the right exit code, and nothing lost.

#include <sys/stat.h>

#include <catch2/catch.hpp>
#include <cmath>
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

const std::string kPendulumSpec = (fs::path(BAYESCTRL_SOURCE_DIR) / "configs" / "real" / "dfki_pendulum.yaml").string();

/// 3 s of a slide that oscillates, with columns t, q, u.
void write_swing(const fs::path& file) {
  std::ostringstream csv;
  csv << "t,q,u\n";
  for (int k = 0; k < 300; ++k) {
    const double t = 0.01 * k;
    csv << t << "," << std::sin(2.0 * t) + 1e-4 * std::sin(1e4 * k) << "," << -4.0 * std::sin(2.0 * t) << "\n";
  }
  write_file(file, csv.str());
}

std::string diagnosis_text(const std::string& name, const std::string& recording) {
  return "name: " + name +
         "\nmodel: {plant: mass, parameters: {mass: 1, friction: 0}}\n"
         "signals: {time: t, position: q, input: u}\nrecordings: [" +
         recording + "]\n";
}

void check_refused(const CommandResult& result, int status, const std::string& words) {
  CAPTURE(result.out, result.err);
  CHECK(result.status == status);
  CHECK_THAT(result.err, Contains(words));
  CHECK_THAT(result.err, !Contains("bug"));
}

}  // namespace

TEST_CASE("What a prior model says of its uncertainty is one number for all joints or one for each, above 0",
          "[apps]") {
  const Folder folder;
  const std::string spec = folder.path() / "doubt.yaml";
  write_file(spec, slide_text());
  const auto refused = [&](const std::string& uncertainty, const std::string& why) {
    const std::string model = "belief.prior_model={plant: mass, uncertainty: " + uncertainty + "}";
    check_refused(bayesctrl_with({"validate", spec, "--set", model}), 3, why);
  };
  refused("{drift: [0.1, 0.2], input_gain: [0.1]}", "uncertainty: drift has one number");
  refused("{drift: [0], input_gain: [0.1]}", "must be a number greater than 0");
  refused("{drift: [0.1]}", "uncertainty needs 'input_gain'");
  refused("{drift: [0.1], input_gain: [0.1], couplings: [1]}", "did you mean 'coupling'?");
}

TEST_CASE("A horizon that no recording holds is refused with those that are held", "[apps][attack]") {
  const Folder folder;
  const std::string out = folder.path() / "out";
  for (const char* horizon : {"1e4", "1e-4"}) {
    const CommandResult result =
        bayesctrl_with({"diagnose", kPendulumSpec, "--set", std::string("horizon_s=") + horizon, "--out", out});
    check_refused(result, 3, "horizon_s = ");
    CHECK_THAT(result.err, Contains("recordings without a gap hold windows of"));
  }
  CHECK_FALSE(fs::exists(out));
  write_swing(folder.path() / "run.csv");
  write_file(folder.path() / "model.yaml",
             "name: slide\nmodel: {plant: mass, parameters: {mass: 1, friction: 0}}\n"
             "signals: {time: t, position: q, input: u}\n");
  const std::string model = folder.path() / "model.yaml", input = folder.path() / "run.csv";
  check_refused(bayesctrl_with({"simulate", model, "--input", input, "--horizon", "100"}), 3, "to 2.99 s");
  CHECK(bayesctrl_with({"simulate", model, "--input", input, "--horizon", "2"}).status == 0);
}

TEST_CASE("A number that is none is no number of an option", "[apps][attack]") {
  for (const char* number : {"nan", "inf", "-1", "0", "1e999", "two"}) {
    CAPTURE(number);
    CHECK(bayesctrl_with({"trial", "trial.yaml", "--scale", number}).status == 2);
    CHECK(bayesctrl_with({"simulate", "model.yaml", "--horizon", number}).status == 2);
  }
}

TEST_CASE("Several diagnoses are read before any is made, and none takes the place of another", "[apps][attack]") {
  const Folder folder;
  const auto file = [&](const std::string& name) { return (folder.path() / name).string(); };
  write_swing(file("run.csv"));
  write_file(file("a.yaml"), diagnosis_text("slide", "run.csv"));
  write_file(file("b.yaml"), diagnosis_text("slide", "run.csv"));
  write_file(file("broken.yaml"), diagnosis_text("other", "run.csv") + "horizon: 1\n");
  write_file(file("lost.yaml"), diagnosis_text("lost", "nowhere.csv"));
  const std::string out = file("out");
  check_refused(bayesctrl_with({"diagnose", file("a.yaml"), file("b.yaml"), "--out", out}), 3,
                "has the name 'slide' of");
  check_refused(bayesctrl_with({"diagnose", file("a.yaml"), file("broken.yaml"), "--out", out}), 3, "horizon_s");
  check_refused(bayesctrl_with({"diagnose", file("a.yaml"), file("lost.yaml"), "--out", out}), 3, "nowhere.csv");
  CHECK_FALSE(fs::exists(out));
  write_file(file("c.yaml"), diagnosis_text("third", "run.csv"));
  write_file(file("out/third"), "in the way");
  check_refused(bayesctrl_with({"diagnose", file("a.yaml"), file("c.yaml"), "--out", out}), 6, "third");
  CHECK_FALSE(fs::exists(file("out/slide")));
}

TEST_CASE("A quadrature of more steps than a run may have is refused", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml";
  write_file(spec, slide_text());
  check_refused(bayesctrl_with({"run", spec, "--set", "output.quadrature_step=1e-12", "--out", folder.path() / "out"}),
                3, "steps, at most 1e+07");
}

TEST_CASE("An inertia that is nowhere positive is refused where it is written", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "custom.yaml";
  write_swing(folder.path() / "run.csv");
  for (const char* inertia : {"-1", "0", "-q^2 - 1", "m - 2"}) {
    write_file(spec, "name: custom\nmodel: {plant: custom, parameters: {m: 1}, acceleration: [u],\n  inertia: [\"" +
                         std::string(inertia) +
                         "\"]}\nsignals: {time: t, position: q, input: u}\nrecordings: [run.csv]\n");
    check_refused(bayesctrl_with({"validate", spec}), 3, "custom.yaml:3:13: inertia '" + std::string(inertia) + "'");
  }
}

TEST_CASE("A second lag in one joint is refused where it is written", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "lags.yaml";
  write_swing(folder.path() / "run.csv");
  write_file(
      spec,
      "name: lags\nmodel:\n  plant: mass\n  effects:\n    - {type: actuator_lag, joint: 1, time_constant: 0.05}\n"
      "    - {type: actuator_lag, joint: 1, time_constant: 0.02}\n"
      "signals: {time: t, position: q, input: u}\nrecordings: [run.csv]\n");
  check_refused(bayesctrl_with({"validate", spec}), 3, "lags.yaml:6:7: joint 1 has a lag already");
}

TEST_CASE("A folder that is locked is told as such, and what is in it is left alone", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml";
  const fs::path locked = folder.path() / "locked";
  write_file(spec, slide_text());
  write_file(locked / "note.txt", "keep");
  const auto as_user = [&](std::vector<std::string> command) {  // whom permissions bind, though it may be root
    command.insert(command.begin(), {"setpriv", "--bounding-set=-dac_override,-dac_read_search", BAYESCTRL_BINARY});
    return run_command(command);
  };
  for (const fs::perms rights : {fs::perms::none, fs::perms::owner_read | fs::perms::owner_exec}) {
    fs::permissions(locked, rights);
    check_refused(as_user({"run", spec, "--out", locked / "out"}), 6, "locked");
    check_refused(as_user({"simulate", spec, "--out", locked / "out.csv"}), 6, "locked");
    check_refused(as_user({"sweep", spec, "--set", "sweep={repeat: 2}", "--out", locked / "out"}), 6, "locked");
    check_refused(as_user({"report", locked / "out"}), 6, "locked");
  }
  fs::permissions(locked, fs::perms::owner_all);
  CHECK(read_file(locked / "note.txt", 100) == "keep");
  CHECK(std::distance(fs::directory_iterator(locked), {}) == 1);
}

TEST_CASE("What is no file is no spec: devices, links in a circle, names that are too long", "[apps][attack]") {
  const Folder folder;
  check_refused(bayesctrl_with({"validate", "/dev/zero"}), 6, "is a device");
  fs::create_symlink(folder.path() / "a.yaml", folder.path() / "b.yaml");
  fs::create_symlink(folder.path() / "b.yaml", folder.path() / "a.yaml");
  check_refused(bayesctrl_with({"validate", folder.path() / "a.yaml"}), 6, "a.yaml");
  check_refused(bayesctrl_with({"validate", std::string(300, 'x')}), 6, "too long");
  check_refused(bayesctrl_with({"report", std::string(300, 'x')}), 6, "too long");
  write_file(folder.path() / "d.yaml", diagnosis_text("long", std::string(300, 'x')));
  check_refused(bayesctrl_with({"diagnose", folder.path() / "d.yaml"}), 6, "too long");
}

TEST_CASE("A pipe into which nobody writes is given up", "[apps][attack][slow]") {
  const Folder folder;
  const std::string pipe = folder.path() / "pipe.yaml";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  check_refused(bayesctrl_with({"validate", pipe}), 6, "pipe into which nothing is written");
}

TEST_CASE("Results of another form are named, and are no bug", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml", out = folder.path() / "out", own = out + "/slide";
  write_file(spec, slide_text());
  REQUIRE(bayesctrl_with({"run", spec, "--out", out, "--quiet"}).status == 0);
  for (const char* file : {"summary.json", "provenance.json"}) {
    const std::string before = read_file(own + "/" + file, 10'000'000);
    for (const char* text : {"[1, 2]", "{\"controllers\": 3}", "null", "\"text\""}) {
      CAPTURE(file, text);
      write_file(own + "/" + file, text);
      for (const std::vector<std::string>& command : {std::vector<std::string>{"report", own},
                                                      {"diff", own, own},
                                                      {"run", spec, "--out", out, "--resume", "--quiet"}}) {
        CAPTURE(command);
        const CommandResult result = bayesctrl_with(command);
        CHECK_THAT(result.err, !Contains("bug"));
        CHECK((result.status == 0 || result.status == 1 || result.status == 3));
      }
    }
    write_file(own + "/" + file, before);
  }
  write_file(folder.path() / "diagnosis.json", "[]");
  check_refused(bayesctrl_with({"report", folder.path()}), 3, "diagnosis.json");
}

TEST_CASE("A run that fails says why, however quiet it is told to be", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml";
  write_file(spec, slide_text());
  const CommandResult result =
      bayesctrl_with({"run", spec, "--out", folder.path() / "out", "--quiet", "--set", "model.parameters.mass=1e-300"});
  CAPTURE(result.err);
  CHECK((result.status == 4 || result.status == 5));
  CHECK(result.out.empty());
  CHECK_THAT(result.err, Contains("error: ") && Contains("slide, ") && Contains(": "));
}

TEST_CASE("A page that was not written before the end is written when the run is resumed", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "slide.yaml", out = folder.path() / "out";
  write_file(spec, slide_text());
  REQUIRE(bayesctrl_with({"run", spec, "--out", out, "--quiet"}).status == 0);
  const std::string page = read_file(out + "/slide/report.html", 10'000'000);
  fs::remove(out + "/slide/report.html");
  REQUIRE(bayesctrl_with({"run", spec, "--out", out, "--quiet", "--resume"}).status == 0);
  REQUIRE(fs::exists(out + "/slide/report.html"));
  CHECK(read_file(out + "/slide/report.html", 10'000'000) == page);
}

TEST_CASE("A recording that is none is told what it is", "[apps][attack]") {
  const Folder folder;
  const fs::path run = folder.path() / "run.csv";
  write_swing(run);
  const std::string good = read_file(run, 1'000'000), spec = folder.path() / "a.yaml";
  write_file(spec, diagnosis_text("slide", "run.csv"));
  const auto diagnosed = [&](const std::string& csv) {
    write_file(run, csv);
    return bayesctrl_with({"diagnose", spec, "--out", folder.path() / "out", "--no-report"});
  };
  std::string carriage = good, still = "t,q,u\n", slow = "t,q,u\n";
  for (char& c : carriage) c = c == '\n' ? '\r' : c;
  for (int k = 0; k < 300; ++k) {
    const std::string values = "," + std::to_string(std::sin(0.02 * k)) + ",1\n";
    still += std::to_string(k / 100) + values;
    slow += std::to_string(10 * k) + values;
  }
  CHECK(diagnosed(good).status == 0);
  CHECK(diagnosed(carriage).status == 0);
  check_refused(diagnosed(good.substr(0, 900) + std::string(50, '\0')), 3, "holds a byte 0");
  check_refused(diagnosed(still), 3, "only 3 of 300 rows have a time of their own");
  check_refused(diagnosed("t,q,u\n1,0,0\n1,1,1\n1,2,0\n1,3,1\n"), 3, "only 1 of 4 rows have a time of their own");
  check_refused(diagnosed("t,q,u\n1,0,0\n"), 3, "only 1 samples: too short");
  CHECK_THAT(diagnosed(slow).out, Contains("milliseconds"));
  write_file(spec, diagnosis_text("slide", "''"));
  check_refused(bayesctrl_with({"diagnose", spec}), 3, "file is empty");
}

TEST_CASE("A recording that is given twice, or copied, is not counted twice", "[apps][attack]") {
  const Folder folder;
  const std::string spec = folder.path() / "a.yaml";
  write_swing(folder.path() / "run.csv");
  write_swing(folder.path() / "copy.csv");
  const auto given = [&](const std::string& recordings) {
    write_file(spec, diagnosis_text("slide", recordings));
    return bayesctrl_with({"diagnose", spec, "--out", folder.path() / "out", "--no-report"});
  };
  check_refused(given("run.csv, run.csv"), 3, "a.yaml:4:23: 'run.csv' is there already");
  check_refused(given("run.csv, {file: run.csv, from: 2.5}"), 3, "is there already");
  check_refused(given("run.csv, copy.csv"), 3, "'copy.csv' holds the samples of 'run.csv'");
  CHECK(given("{file: run.csv, to: 1.4}, {file: run.csv, from: 1.5}").status == 0);
}

TEST_CASE("A spec or table of a gigabyte is refused without being read, a billion nested aliases as well",
          "[apps][attack]") {
  const Folder folder;
#ifdef __SANITIZE_ADDRESS__  // which takes terabytes of address space
  const std::string limit;
#else
  const std::string limit = "ulimit -v 400000; ";  // kB
#endif
  const auto bounded = [&](const std::string& command) {
    return run_command({"bash", "-c", limit + "exec " BAYESCTRL_BINARY " " + command}, folder.path());
  };
  write_file(folder.path() / "big.yaml", "name: ");
  fs::resize_file(folder.path() / "big.yaml", std::uintmax_t{1} << 30);  // one line, of zeros
  check_refused(bounded("validate big.yaml"), 3, "at most 1048576");
  check_refused(bounded("sweep big.yaml --out out"), 3, "at most 1048576");
  fs::create_directory(folder.path() / "results");
  write_file(folder.path() / "results" / "table.csv", "experiment,controller,status\n");
  fs::resize_file(folder.path() / "results" / "table.csv", std::uintmax_t{1} << 30);
  check_refused(bounded("table results"), 3, "table.csv: has more than 268435456 bytes");

  std::string aliases = "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 10; ++i) {
    const std::string own = "a" + std::to_string(i), below = "*a" + std::to_string(i - 1);
    aliases += own + ": &" + own + " [" + below;
    for (int k = 1; k < 10; ++k) aliases += ", " + below;
    aliases += "]\n";
  }
  write_file(folder.path() / "aliases.yaml", aliases);
  check_refused(bounded("validate aliases.yaml"), 3, "aliases.yaml:");
  check_refused(bounded("run aliases.yaml"), 3, "aliases.yaml:");
}

TEST_CASE("Names that climb out of their folder stay in it, recordings elsewhere are told as missing",
          "[apps][attack]") {
  const Folder folder;
  const fs::path inside = folder.path() / "a" / "b";
  fs::create_directories(inside);
  std::string text = slide_text();
  text.replace(text.find("name: slide"), 11, "name: ../../etc/x");
  write_file(inside / "slide.yaml", text);
  CHECK(bayesctrl_with({"run", "slide.yaml", "--out", "out", "--quiet"}, inside).status == 0);
  CHECK(bayesctrl_with({"sweep", "slide.yaml", "--quiet"}, inside).status == 0);
  CHECK_FALSE(fs::exists(folder.path() / "etc"));
  CHECK_FALSE(fs::exists(folder.path() / "a" / "etc"));
  write_file(inside / "d.yaml", diagnosis_text("../../etc/x", "../../etc/x"));
  check_refused(bayesctrl_with({"diagnose", "d.yaml"}, inside), 3, "../../etc/x");
  check_refused(bayesctrl_with({"sweep", "d.yaml"}, inside), 3, "../../etc/x");
}
