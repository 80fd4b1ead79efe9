#include "experiment/read.hpp"

#include <algorithm>
#include <catch2/catch.hpp>

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

using Points = std::vector<std::vector<std::pair<std::string, std::string>>>;

/// The studies of the slide's spec with `more` below it.
class SpecFile {
 public:
  explicit SpecFile(const std::string& more) { write_file(path(), slide_text() + more); }
  std::filesystem::path path() const { return folder_.path() / "spec.yaml"; }
  std::vector<Study> studies(const Overrides& overrides = {}) const { return read_studies(path(), overrides); }

  /// The message, without the folder.
  std::string error(const Overrides& overrides = {}) const {
    const std::string text = error_of([&] { studies(overrides); });
    const std::string folder = folder_.path().string() + "/";
    return text.starts_with(folder) ? text.substr(folder.size()) : text;
  }

 private:
  Folder folder_;
};

Points points_of(const std::vector<Study>& studies) {
  Points points;
  for (const Study& study : studies) points.push_back(study.point);
  return points;
}

}  // namespace

TEST_CASE("A sweep is every combination, the last path varying fastest", "[experiment]") {
  const std::vector<Study> studies = SpecFile("sweep: {controllers.P1.gain: [1, 2.5], seed: [3, 4, 5]}").studies();
  const std::string gain = "controllers.P1.gain";
  CHECK(points_of(studies) == Points{{{gain, "1"}, {"seed", "3"}},
                                     {{gain, "1"}, {"seed", "4"}},
                                     {{gain, "1"}, {"seed", "5"}},
                                     {{gain, "2.5"}, {"seed", "3"}},
                                     {{gain, "2.5"}, {"seed", "4"}},
                                     {{gain, "2.5"}, {"seed", "5"}}});
  REQUIRE(studies.size() == 6);
  CHECK(studies[4].seed == 4);
  CHECK(std::get<Proportional>(*studies[4].controllers.find("P1")).gain == 2.5);
  for (const Study& study : studies) CHECK(study.name == "slide");
}

TEST_CASE("The points of a sweep are columns of its tables, after the experiment's name", "[experiment]") {
  const std::vector<Study> studies = SpecFile("sweep: {controllers.P1.gain: [1, 2.5]}").studies();
  Table table;
  for (const Study& study : studies) append(table, summary_table(run_one(study)));
  CHECK(column_names(table)[0] == "experiment");
  CHECK(column_names(table)[1] == "controllers.P1.gain");
  CHECK(column_texts(table, "controllers.P1.gain") ==
        std::vector<std::string>{"1", "1", "1", "1", "2.5", "2.5", "2.5", "2.5"});
}

TEST_CASE("A sweep takes values of every kind as they stand in the file", "[experiment]") {
  const std::string texts = R"(sweep:
  description: ['a "b" \ c', "true", 'x, y', plain # remark
    , "two\nlines", 'name: value', '[1, 2]', '']
)";
  std::vector<std::string> descriptions;
  for (const Study& study : SpecFile(texts).studies()) descriptions.push_back(study.description);
  CHECK(descriptions ==
        std::vector<std::string>{"a \"b\" \\ c", "true", "x, y", "plain", "two\nlines", "name: value", "[1, 2]", ""});

  const auto learners = SpecFile(
                            "sweep:\n  learner:\n    - {period: 0.2, drift_threshold: 1, gain_threshold: 2, "
                            "probing_input: [7], schedule: \"after_probe\"}\n  reference.position: [[2], 3]\n")
                            .studies();
  REQUIRE(learners.size() == 2);
  CHECK(learners[0].learner->probing_input == std::vector<double>{7.0});
  CHECK(learners[0].learner->schedule == Schedule::after_probe);
  CHECK(std::get<Setpoint>(learners[1].reference).position == std::vector<double>{3.0});

  const auto limits = SpecFile("sweep: {output.quadrature_step: [null, 1.0e-3]}").studies();
  CHECK(!limits[0].output.quadrature_step);
  CHECK(limits[1].output.quadrature_step == 1e-3);
}

TEST_CASE("A sweep's mistakes are refused, with the place in the file", "[experiment]") {
  const std::string spec = slide_text();
  const std::string lines = std::to_string(std::count(spec.begin(), spec.end(), '\n') + 1);
  const auto error = [](const std::string& sweep) { return SpecFile("sweep: {" + sweep + "}").error(); };
  CHECK(error("controllers.P1.gian: [1]") ==
        "spec.yaml:" + lines + ":9: --set controllers.P1.gian=1: proportional has no 'gian', did you mean 'gain'?");
  CHECK(error("seed: [1], controllers.P1.gain: [1, two]") ==
        "spec.yaml:" + lines +
            ":20: --set controllers.P1.gain=two: gain = two, must be a number of at least 0 (unit of u per rad/s^2)");
  CHECK(error("belief.drift.kernel.length_scales.7: [1]") ==
        "spec.yaml:" + lines +
            ":9: --set belief.drift.kernel.length_scales.7=1: 'length_scales' is a list of 2, 0 to 1, it has no item "
            "'7'");
  CHECK(error("seed: 3") == "spec.yaml:" + lines + ":15: seed = 3, must be a list");
  CHECK(error("seed: []") == "spec.yaml:" + lines + ":9: sweep over 'seed' has no values");
  CHECK(SpecFile("sweep: [1]").error() == "spec.yaml:" + lines + ":8: sweep is a list, must be a map");
}

TEST_CASE("A sweep of more points than memory can take is refused before it is expanded", "[experiment]") {
  std::string sweep = "sweep: {";
  for (const char* path :
       {"seed", "duration", "control_period", "model.parameters.mass", "model.parameters.friction", "learner.period"}) {
    sweep += (sweep.back() == '{' ? "" : ", ") + std::string(path) + ": [1, 2, 3, 4, 5, 6, 7, 8, 9, 10]";
  }
  CHECK_THAT(SpecFile(sweep + "}").error(), Catch::EndsWith("the sweep has more than 100000 points"));
}

TEST_CASE("Overrides change every study, the seed of the command line comes last", "[experiment]") {
  const SpecFile file("sweep: {controllers.P1.gain: [1, 2]}");
  const std::vector<Study> studies = file.studies({{"duration=3", "name=other", "description=a=b"}, 9});
  REQUIRE(studies.size() == 2);
  for (const Study& study : studies) {
    CHECK(study.duration == 3.0);
    CHECK(study.name == "other");
    CHECK(study.description == "a=b");
    CHECK(study.seed == 9);
  }
  CHECK(file.studies({{"sweep={}"}, {}}).size() == 1);
}

TEST_CASE("An override with an unknown path is refused with a suggestion", "[experiment]") {
  const SpecFile file("");
  CHECK(file.error({{"controllers.P1.gian=3"}, {}}) ==
        "--set controllers.P1.gian=3: proportional has no 'gian', did you mean 'gain'?");
  CHECK(file.error({{"contrllers.P1.gain=3"}, {}}) ==
        "--set contrllers.P1.gain=3: study has no 'contrllers', did you mean 'controllers'?");
  CHECK(file.error({{"duration"}, {}}) == "--set duration: has no '=', write path=value");
}
