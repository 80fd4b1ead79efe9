#include "inspect/difference.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "experiment/write.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/studies.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

ResultValues ran(const Folder& folder, const std::string& name, const std::vector<std::string>& changes) {
  write_results(run_one(slide(changes)), folder.path() / name, "slide.yaml");
  return read_results(folder.path() / name);
}

ResultValues found(const Folder& folder, const std::string& name, const Diagnosis& diagnosis) {
  write_file(folder.path() / name / "diagnosis.json", to_json(diagnosis).dump());
  return read_results(folder.path() / name);
}

ResultValues tried(const Folder& folder, const std::string& name, const std::string& summary) {
  write_file(folder.path() / name / "summary.json", summary);
  return read_results(folder.path() / name);
}

Diagnosis dry_friction(double level, double seconds) {
  Diagnosis d;
  d.name = "x";
  d.verdict = Verdict::named;
  d.units.resize(1);
  d.explanation.effects = {{"coulomb_friction", 1, {{{"level", {level, 0.01, "N m"}}}}, {}, "dry"}};
  d.seconds = seconds;
  return d;
}

}  // namespace

TEST_CASE("A result does not differ from itself, nor from the same run again", "[inspect]") {
  const Folder folder;
  const ResultValues first = ran(folder, "a", {}), again = ran(folder, "b", {});
  CHECK(difference({first, first}).empty());
  CHECK(difference({first, again}).empty());
  CHECK(first.kind == "experiment");
  CHECK(first.settings.size() > 20);
  CHECK(first.metrics.size() > 20);
}

TEST_CASE("The one setting that was changed is the one that differs, and the metrics with their change", "[inspect]") {
  const Folder folder;
  const ResultDifference result =
      difference({ran(folder, "a", {}), ran(folder, "b", {"controllers.P1.gain=2"}), ran(folder, "c", {"seed=7"})});
  REQUIRE(result.settings.rows() == 2);
  CHECK(column_texts(result.settings, "setting") == std::vector<std::string>{"seed", "controllers.P1.gain"});
  CHECK(column_texts(result.settings, (folder.path() / "b").string()) == std::vector<std::string>{"1", "2"});
  const std::vector<std::string> metrics = column_texts(result.metrics, "metric");
  for (const std::string& name : metrics)
    CHECK_THAT(name, Catch::StartsWith("P1."));  // no noise: the seed changes nothing
  const auto energy = std::find(metrics.begin(), metrics.end(), "P1.energy") - metrics.begin();
  const double a = metric(run_one(slide()), "P1", "energy");
  const double b = metric(run_one(slide({"controllers.P1.gain=2"})), "P1", "energy");
  const Cell change = result.metrics.columns[4].at(static_cast<std::size_t>(energy));
  CHECK(std::get<double>(change) == Approx(100.0 * (b / a - 1.0)));
}

TEST_CASE("Diagnoses are compared by what they found, not by how long it took", "[inspect]") {
  const Folder folder;
  const ResultDifference result =
      difference({found(folder, "a", dry_friction(0.3, 1.5)), found(folder, "b", dry_friction(0.6, 9.5))});
  CHECK(result.settings.rows() == 0);
  REQUIRE(result.metrics.rows() == 1);
  CHECK(column_texts(result.metrics, "metric").front() ==
        "explanation.effects.coulomb_friction.parameters.level.value");
  CHECK(std::get<double>(result.metrics.columns[3].at(0)) == Approx(100.0));
}

TEST_CASE("What one result lacks is missing in its column", "[inspect]") {
  const Folder folder;
  const ResultDifference result =
      difference({tried(folder, "a", R"({"only": 1, "both": 2})"), tried(folder, "b", R"({"both": 2, "other": 3})")});
  REQUIRE(result.metrics.rows() == 2);
  CHECK(std::holds_alternative<std::monostate>(result.metrics.columns[2].at(0)));
  CHECK(std::holds_alternative<std::monostate>(result.metrics.columns[1].at(1)));
}

TEST_CASE("Folders without results, broken ones and different kinds are refused", "[inspect]") {
  const Folder folder;
  CHECK_THROWS_AS(read_results(folder.path() / "nowhere"), IoError);
  CHECK_THROWS_WITH(read_results(folder.path()), Contains("holds no diagnosis.json, summary.json or table.csv"));
  write_file(folder.path() / "broken" / "diagnosis.json", "{");
  CHECK_THROWS_AS(read_results(folder.path() / "broken"), DataError);
  write_file(folder.path() / "broken" / "diagnosis.json", R"({"name": "x"})");
  CHECK_THROWS_WITH(read_results(folder.path() / "broken"), Contains("diagnosis.json: lacks the key 'verdict'"));
  CHECK_THROWS_WITH(difference({ran(folder, "a", {}), found(folder, "b", dry_friction(0.3, 1.0))}),
                    Contains("of another kind"));
}
