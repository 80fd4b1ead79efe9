#include "sweep/sensitivity.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "report/claims_picture.hpp"
#include "support/command.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

/// A sensitivity of the slide: of P1 the energy grows with its gain, so that a claim about it holds for low gains
/// alone.
struct Written {
  explicit Written(const std::string& claims, const std::string& more = "") {
    write_file(folder.path() / "slide.yaml", slide_text());
    write_file(spec,
               "name: s\nsource: nobody\ncount: 200\nseed: 3\nexperiments:\n"
               "  a: {study: slide.yaml, settings: {controllers.P1.gain: {type: uniform, low: 1, high: 3}}}\n"
               "  b: {study: slide.yaml, settings: {controllers.P1.gain: {type: uniform, low: 1, high: 3}" +
                   more + "}}\nclaims:\n" + claims);
  }
  Folder folder;
  fs::path spec = folder.path() / "s.yaml";

  SensitivityResult run(int jobs = 1) const {
    SensitivityOptions options;
    options.jobs = jobs;
    return *run_sensitivity(read_sensitivity(read_yaml(spec)), folder.path(),
                            folder.path() / ("out" + std::to_string(jobs)), options);
  }
  std::string error() const {
    const std::string text = error_of<Error>([&] { read_sensitivity(read_yaml(spec)); });
    const std::string place = folder.path().string() + "/";
    return text.starts_with(place) ? text.substr(place.size()) : text;
  }
};

}  // namespace

TEST_CASE("The share of draws in which a claim holds, and the setting on which it depends", "[sweep]") {
  const double limit = metric(run_one(slide({"controllers.P1.gain=2"})), "P1", "energy");
  const Written written("  - {text: low, holds: a.P1.energy < " + std::to_string(limit) +
                        "}\n  - {text: same, holds: a.P1.energy == b.P1.energy && a.SP1.energy == b.SP1.energy}\n"
                        "  - {text: never, holds: a.P1.energy < 0}\n");
  const SensitivityResult result = written.run();
  const std::vector<double> share = numbers(result.claims, "share", ""), n = numbers(result.claims, "n", "");
  CHECK(n == std::vector<double>{200, 200, 200});
  CHECK(share[0] == Approx(0.5).margin(0.12));  // gains below 2, of those from 1 to 3
  CHECK(share[1] == 1.0);                       // draws of the same number have the same settings
  CHECK(share[2] == 0.0);
  CHECK(column_texts(result.claims, "setting")[0] == "a: controllers.P1.gain");
  CHECK(numbers(result.claims, "share_lowest", "")[0] == 0.0);
  CHECK(numbers(result.claims, "share_highest", "")[0] == 1.0);
  CHECK(numbers(result.claims, "low", "")[0] < share[0]);
  CHECK(numbers(result.claims, "high", "")[0] > share[0]);
  // Fifths of a setting hold a fifth of the draws each, and their shares make up the whole.
  const std::vector<double> bins = numbers(result.by_setting, "n", ""), part = numbers(result.by_setting, "share", "");
  double sum = 0.0;
  for (std::size_t b = 0; b < 5; ++b) {
    CHECK(bins[b] == 40.0);
    sum += part[b] / 5.0;
  }
  CHECK(sum == Approx(share[0]));
  CHECK(to_csv(written.run(2).claims) == to_csv(result.claims));

  const std::string picture = claims_picture(result.claims, result.by_setting);
  CHECK_THAT(picture, Catch::StartsWith("<svg ") && Catch::EndsWith("</svg>\n") && Catch::Contains(">never<"));
}

TEST_CASE("A claim about a run that failed does not hold, and the failures are counted", "[sweep]") {
  std::string more;
  for (const std::string& change : unstable()) {
    const std::size_t equals = change.find('=');
    if (change.starts_with("duration")) continue;
    more += ", " + change.substr(0, equals) + ": {type: choice, values: ['" + change.substr(equals + 1) + "']}";
  }
  const Written written("  - {text: any, holds: b.SP1.energy > -1}\n",
                        more + ", duration: {type: choice, values: ['20']}");
  const SensitivityResult result = written.run();
  CHECK(numbers(result.claims, "n_failed", "")[0] == 200.0);
  CHECK(numbers(result.claims, "share", "")[0] == 0.0);
}

TEST_CASE("Wilson's interval of a share", "[sweep]") {
  const auto [low, high] = share_interval(81, 263);  // Newcombe (1998), table 1: 0.2553 to 0.3662
  CHECK(low == Approx(0.2553).margin(5e-5));
  CHECK(high == Approx(0.3662).margin(5e-5));
  CHECK(share_interval(0, 20).first == 0.0);
  CHECK(share_interval(0, 20).second == Approx(0.1611).margin(5e-5));
  CHECK(share_interval(20, 20).second == 1.0);
}

TEST_CASE("Mistakes in a sensitivity are told at their place", "[sweep]") {
  const auto error = [](const std::string& holds) { return Written("  - {text: x, holds: " + holds + "}\n").error(); };
  CHECK(error("a.P1.enery < 1") == "s.yaml:9:22: 'a.P1.enery': there is no 'enery', did you mean 'energy'?");
  CHECK(error("a.SP3.energy < 1") == "s.yaml:9:22: 'a.SP3.energy': there is no 'SP3', did you mean 'SP1'?");
  CHECK(error("c.P1.energy < 1") == "s.yaml:9:22: 'c.P1.energy': there is no 'c', did you mean 'a'?");
  CHECK(error("energy < 1") == "s.yaml:9:22: 'energy' is not of the form EXPERIMENT.CONTROLLER.METRIC");
  CHECK_THAT(error("a.P1.energy <"), Catch::Contains("write a comparison, e.g."));
  CHECK_THAT(
      Written("  - {text: x, holds: a.P1.energy < 1}\n", ", controllers.P1.gian: {type: uniform, low: 0, high: 1}")
          .error(),
      Catch::Contains("proportional has no 'gian', did you mean 'gain'?"));
}

TEST_CASE("bayesctrl sensitivity writes its tables and its picture, and goes on where it was", "[apps][sweep]") {
  const Written written("  - {group: g, text: low, holds: a.P1.energy < 1000}\n");
  const fs::path out = written.folder.path() / "results";
  const std::vector<std::string> arguments{"sensitivity", written.spec, "--out", out, "--limit", "20"};
  const CommandResult result = bayesctrl_with(arguments);
  CHECK(result.status == 0);
  CHECK_THAT(result.out, Catch::Contains("low") && Catch::Contains("100"));
  for (const char* file : {"claims.csv", "claims.md", "claims.svg", "by_setting.csv", "summary.json", "provenance.json",
                           "a/table.csv", "b/manifest.json"}) {
    CHECK(fs::exists(out / file));
  }
  const auto before = files_below(out);
  fs::remove_all(out / "b" / "results");
  CHECK(bayesctrl_with(arguments).status == 0);
  CHECK(files_below(out).at("claims.csv") == before.at("claims.csv"));
}
