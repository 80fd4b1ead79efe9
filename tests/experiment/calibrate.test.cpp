#include "experiment/calibrate.hpp"

#include <catch2/catch.hpp>
#include <iomanip>
#include <set>
#include <sstream>

#include "experiment/tabulate.hpp"
#include "io/examples.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using io_examples::error_of;
using io_examples::Folder;

namespace {

/// A search for the slide's P gain whose answer is known: the published energy is that of gain 3.
class GainSearch {
 public:
  explicit GainSearch(const std::string& vary = "{controllers.P1.gain: {low: 0.5, high: 20}}",
                      const std::string& more = "controllers: [P1]",
                      const std::string& effort = "draws: 10\nsteps: 60\ndigits: 1") {
    const double energy = metric(run_one(slide({"controllers.P1.gain=3"})), "P1", "energy");
    std::ostringstream value;
    value << std::setprecision(17) << energy;
    write_file(folder_.path() / "slide.yaml", slide_text());
    write_file(folder_.path() / "published.yaml",
               "name: T\nsource: computed with gain 3\ncells:\n"
               "  - {experiment: slide, controller: P1, metric: energy, relative: 1.0e-6, value: " +
                   value.str() +
                   "}\n"
                   "  - {experiment: another, controller: P1, metric: energy, absolute: 1, value: 1.0e+6}\n");
    write_file(file(), "study: slide.yaml\nagainst: [published.yaml]\nvary: " + vary + "\nstarts: 3\n" + effort + "\n" +
                           more + "\n");
  }

  std::filesystem::path file() const { return folder_.path() / "search.yaml"; }

  std::string error() const {
    const std::string text = error_of([&] { calibrate(file(), 1); });
    const std::string folder = folder_.path().string() + "/";
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }

 private:
  Folder folder_;
};

using Summary = std::vector<std::pair<std::vector<std::string>, double>>;

Summary summary(const std::vector<CalibrationResult>& results) {
  Summary list;
  for (const CalibrationResult& result : results) list.emplace_back(result.assignments, result.score);
  return list;
}

}  // namespace

TEST_CASE("A calibration finds the setting that the published number was computed with", "[experiment]") {
  const std::vector<CalibrationResult> results = calibrate(GainSearch().file(), 1);
  REQUIRE(results.size() == 3);
  CHECK(results.front().assignments == std::vector<std::string>{"controllers.P1.gain=3"});
  CHECK(column_texts(results.front().comparison, "ok") == std::vector<std::string>{"yes"});
  CHECK(results[0].score <= results[1].score);
  CHECK(results[1].score <= results[2].score);
}

TEST_CASE("Searches that end in one place are one candidate", "[experiment]") {
  const std::vector<CalibrationResult> ended = calibrate(GainSearch().file(), 1), shown = distinct(ended);
  std::set<std::vector<std::string>> settings;
  for (const CalibrationResult& result : ended) settings.insert(result.assignments);
  REQUIRE(settings.size() < ended.size());
  REQUIRE(shown.size() == settings.size());
  int searches = 0;
  for (std::size_t i = 0; i < shown.size(); ++i) {
    searches += shown[i].searches;
    CHECK(settings.erase(shown[i].assignments) == 1);
    CHECK((i == 0 || shown[i - 1].score <= shown[i].score));
  }
  CHECK(searches == static_cast<int>(ended.size()));
}

TEST_CASE("A calibration chooses among given values as well", "[experiment]") {
  const GainSearch search("{controllers.P1.gain: {choices: [1, 2, 3, 5]}, description: {choices: [x]}}");
  CHECK(calibrate(search.file(), 1).front().assignments ==
        std::vector<std::string>{"controllers.P1.gain=3", "description=x"});
}

TEST_CASE("The searches of a calibration begin in different places", "[experiment]") {
  const GainSearch search("{controllers.P1.gain: {low: 0.5, high: 20}}", "", "draws: 1\nsteps: 0\ndigits: 6");
  std::set<std::string> starts;
  for (const CalibrationResult& result : calibrate(search.file(), 1)) starts.insert(result.assignments.front());
  CHECK(starts.size() == 3);
}

TEST_CASE("A calibration's result does not depend on the number of threads", "[experiment]") {
  const GainSearch search;
  const Summary expected = summary(calibrate(search.file(), 1));
  for (const int jobs : {2, 7}) CHECK(summary(calibrate(search.file(), jobs)) == expected);
}

TEST_CASE("A calibration that is stopped returns the searches that were finished", "[experiment]") {
  const GainSearch search;
  std::size_t finished = 0;
  const auto results = calibrate(
      search.file(), 1,
      [&](std::size_t done, std::size_t total) {
        CHECK(total == 3);
        finished = done;
      },
      [&] { return finished == 1; });
  CHECK(results.size() == 1);
}

TEST_CASE("A calibration refuses what it cannot search", "[experiment]") {
  const std::string gain = "{controllers.P1.gain: {low: 1, high: 2}}";
  CHECK(GainSearch("{controllers.P1.gian: {low: 1, high: 2}}")
            .error()
            .find("proportional has no 'gian', did you mean "
                  "'gain'?") != std::string::npos);
  CHECK(GainSearch("{controllers.P1.gain: {low: 2, high: 1}}").error() ==
        "search.yaml:3:29: a varied setting needs either low and high, 0 < low <= high, or choices");
  CHECK(GainSearch("{controllers.P1.gain: {low: 1, high: 2, choices: [1]}}").error() ==
        "search.yaml:3:29: a varied setting needs either low and high, 0 < low <= high, or choices");
  CHECK(GainSearch(gain, "controllers: [P2]").error() ==
        "search.yaml: the study has no controller 'P2', did you mean 'P1'?");
  CHECK(GainSearch(gain, "controllers: [SP2]").error() ==
        "search.yaml: with these controllers alone: controller 'SP2' is trained_from 'SP1', which is no adaptive "
        "controller above it");
  CHECK(GainSearch(gain, "controllers: [oracle]").error() ==
        "search.yaml: no published cell belongs to these controllers");
}
