#include "inspect/difference.hpp"

#include <catch2/catch.hpp>

#include "base/error.hpp"
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

ResultValues found(const Folder& folder, const std::string& name, const std::string& json) {
  write_file(folder.path() / name / "diagnosis.json", json);
  return read_results(folder.path() / name);
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
  const std::string json = R"({"name": "x", "verdict": "named", "seconds": 1.5, "explanation": {"effects": [
    {"name": "coulomb_friction", "joint": 1, "text": "dry", "parameters": {"level": {"value": 0.3, "sd": 0.01}}}]}})";
  std::string other = json;
  other.replace(other.find("0.3"), 3, "0.6");
  other.replace(other.find("1.5"), 3, "9.5");
  const ResultDifference result = difference({found(folder, "a", json), found(folder, "b", other)});
  CHECK(result.settings.rows() == 0);
  REQUIRE(result.metrics.rows() == 1);
  CHECK(column_texts(result.metrics, "metric").front() ==
        "explanation.effects.coulomb_friction.parameters.level.value");
  CHECK(std::get<double>(result.metrics.columns[3].at(0)) == Approx(100.0));
}

TEST_CASE("What one result lacks is missing in its column", "[inspect]") {
  const Folder folder;
  const ResultDifference result =
      difference({found(folder, "a", R"({"only": 1, "both": 2})"), found(folder, "b", R"({"both": 2, "other": 3})")});
  REQUIRE(result.metrics.rows() == 2);
  CHECK(std::holds_alternative<std::monostate>(result.metrics.columns[2].at(0)));
  CHECK(std::holds_alternative<std::monostate>(result.metrics.columns[1].at(1)));
}

TEST_CASE("Folders without results, broken ones and different kinds are refused", "[inspect]") {
  const Folder folder;
  CHECK_THROWS_AS(read_results(folder.path() / "nowhere"), IoError);
  CHECK_THROWS_WITH(read_results(folder.path()), Contains("holds no diagnosis.json, summary.json or table.csv"));
  CHECK_THROWS_AS(found(folder, "broken", "{"), DataError);
  CHECK_THROWS_WITH(difference({ran(folder, "a", {}), found(folder, "b", "{}")}), Contains("of another kind"));
}
