// Real machines beside what others have published of them: what agrees, what is skipped, what fails.

#include "bench/bench.hpp"

#include <catch2/catch.hpp>
#include <sstream>

#include "base/error.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using Catch::Contains;
using io_examples::Folder;
namespace fs = std::filesystem;

namespace {

ExplainedEffect listed(const std::string& name, int joint, double inclusion) {
  ExplainedEffect effect;
  effect.name = name;
  effect.joint = joint;
  effect.inclusion = inclusion;
  return effect;
}

/// The diagnosis of a pendulum, whose recordings are named `file`.
std::string spec_of(const std::string& name, const std::string& file) {
  return "name: " + name + "\nmodel:\n  plant: pendulum\n  parameters: {length: 0.8, friction: 0.2, mass: 0.6}\n" +
         "signals: {time: t, position: q, input: u}\nrecordings: " + file + "\n";
}

std::string csv_of(const Measured& data) {
  std::ostringstream text;
  text.precision(12);
  text << "t,q,u\n";
  for (std::size_t k = 0; k < data.samples(); ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    text << data.time[k] << "," << data.position(row, 0) << "," << data.input(row, 0) << "\n";
  }
  return text.str();
}

std::string text_in(const Table& table, const std::string& column, std::size_t row) {
  const Cell cell = table.find(column)->at(row);
  return std::holds_alternative<std::string>(cell) ? std::get<std::string>(cell) : "";
}

std::string error_of(const fs::path& path) {
  try {
    read_bench(read_yaml(path));
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing thrown";
}

}  // namespace

TEST_CASE("What is certain agrees with what was published, also by another name that cannot be told from it",
          "[bench]") {
  Diagnosis d;
  d.joints = 2;
  d.explanation.effects = {listed("stribeck_friction", 1, 0.99), listed("viscous_friction", 2, 0.6),
                           listed("input_gain", 2, 0.95)};
  d.indistinguishable = {{"stribeck_friction@1", "coulomb_friction@1"}, {"input_gain@2", "added_inertia@2"}};
  const Agreement both = agreement({{"coulomb_friction", 1, ""}, {"viscous_friction", 2, ""}}, d);
  CHECK(both.found == std::vector<std::string>{"coulomb_friction@1"});
  CHECK(both.missed == std::vector<std::string>{"viscous_friction@2"});  // listed, but not certain
  CHECK(both.more == std::vector<std::string>{"input_gain@2"});
  d.joints = 1;
  d.explanation.effects = {listed("coulomb_friction", 1, 0.99)};
  d.indistinguishable.clear();
  CHECK(agreement({{"coulomb_friction", 1, ""}}, d).found == std::vector<std::string>{"coulomb_friction"});
  CHECK(agreement({}, d).more == std::vector<std::string>{"coulomb_friction"});
  d.explanation.effects.clear();  // one of several, any of which alone would do, is neither found nor missed
  d.alone = Alone{{{{"coulomb_friction", 0.99}, {"constant_bias", 0.99}}}, true};
  const Agreement left = agreement({{"coulomb_friction", 1, ""}, {"linear_spring", 1, ""}}, d);
  CHECK(left.found.empty());
  CHECK(left.open == std::vector<std::string>{"coulomb_friction"});
  CHECK(left.missed == std::vector<std::string>{"linear_spring"});
}

TEST_CASE("A bench that cannot be is refused where it is written", "[bench]") {
  const Folder folder;
  write_file(folder.path() / "a.yaml", spec_of("a", "a.csv"));
  const fs::path bench = folder.path() / "bench.yaml";
  const auto with = [&](const std::string& machines) {
    write_file(bench, "machines:\n" + machines);
    return error_of(bench);
  };
  CHECK(with("  - {spec: a.yaml, source: here}\n") == "nothing thrown");
  CHECK_THAT(with("  - {spec: a.yaml, source: here, published: [{effect: coulomb_frction}]}\n"),
             Contains("bench.yaml:2:") && Contains("did you mean 'coulomb_friction'?"));
  CHECK_THAT(with("  - {spec: a.yaml, source: here, published: [{effect: coulomb_friction, joint: 2}]}\n"),
             Contains("'a' has no joint 2"));
  CHECK_THAT(with("  - {spec: a.yaml, source: here}\n  - {spec: a.yaml, source: there}\n"),
             Contains("has the name 'a' of another machine"));
  CHECK_THAT(with("  - {spec: b.yaml, source: here}\n"), Contains("b.yaml"));
  write_file(bench, "machines: []\n");
  CHECK_THAT(error_of(bench), Contains("machines is empty"));
}

TEST_CASE(
    "Every machine of a bench is a row: diagnosed, skipped where its recordings are not, or failed with the reason",
    "[bench][slow]") {
  const Folder folder;
  const fs::path& here = folder.path();
  const Machine machine(testing::kPendulum, {{CoulombFriction{0.4}, 0}});
  write_file(here / "rubs.csv", csv_of(testing::record(machine, -1.0, 7)));
  write_file(here / "broken.csv", "t,q,u\n0,1,x\n");
  write_file(here / "rubs.yaml", spec_of("rubs", "rubs.csv"));
  write_file(here / "away.yaml", spec_of("away", "away.csv"));
  write_file(here / "broken.yaml", spec_of("broken", "broken.csv"));
  write_file(
      here / "bench.yaml",
      "name: three\nmachines:\n"
      "  - {spec: away.yaml, source: elsewhere, published: [{effect: viscous_friction, value: 1 N m s}]}\n"
      "  - {spec: rubs.yaml, source: here, best: 0.01, published: [{effect: coulomb_friction, value: 0.4 N m}]}\n"
      "  - {spec: broken.yaml, source: here}\n");
  const Bench bench = read_bench(read_yaml(here / "bench.yaml"));
  const Table table = run_bench(bench, here / "out", {2});
  REQUIRE(table.rows() == 3);
  CHECK(text_in(table, "status", 0) == "skipped");
  CHECK_THAT(text_in(table, "reason", 0), Contains("away.csv"));
  CHECK(text_in(table, "published", 0) == "viscous_friction (1 N m s)");
  CHECK(text_in(table, "status", 1) == "ok");
  CHECK(text_in(table, "verdict", 1) == "named");
  CHECK(text_in(table, "found", 1) == "coulomb_friction");
  CHECK(text_in(table, "missed", 1).empty());
  CHECK(std::get<double>(table.find("best_published")->at(1)) == 0.01);
  CHECK(std::get<double>(table.find("after")->at(1)) < 0.1 * std::get<double>(table.find("before")->at(1)));
  CHECK(text_in(table, "status", 2) == "failed");
  CHECK_THAT(text_in(table, "reason", 2), Contains("broken.csv:2"));
  CHECK(fs::exists(here / "out" / "rubs" / "diagnosis.json"));
  CHECK(fs::exists(here / "out" / "rubs" / "provenance.json"));
  for (const char* file : {"bench.csv", "bench.json", "bench.md"}) CHECK(fs::exists(here / "out" / file));
  CHECK(run_bench(bench, here / "again", {1}) == table);
}
