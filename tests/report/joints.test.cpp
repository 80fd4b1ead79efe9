// A machine that the user writes down has as many joints as its recordings have positions.

#include <catch2/catch.hpp>
#include <cmath>

#include "diagnose/verdict/diagnosis.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "report/support.hpp"
#include "support/command.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;
using namespace bayesctrl::testing;
using Catch::Contains;
using io_examples::Folder;
using nlohmann::ordered_json;

namespace {

/// A slide and a pendulum, each with its own input; dry friction of 0.3 N m in the pendulum.
void record(const std::filesystem::path& file) {
  std::string csv = "t,x,q,f,m\n";
  double x = 0.0, vx = 0.0, q = 0.5, vq = 0.0;
  constexpr double kStep = 2e-4;
  for (int k = 0; k < 40000; ++k) {
    const double t = std::floor(kStep * k * 100.0 + 1e-9) / 100.0;  // inputs are held
    const double f = std::sin(2.1 * t) + 0.6 * std::cos(5.3 * t), m = 2.0 * std::sin(1.3 * t) + 1.5 * std::sin(3.9 * t);
    if (k % 50 == 0) {
      for (const double value : {kStep * k, x, q, f}) csv += std::to_string(value) + ",";
      csv += std::to_string(m) + "\n";
    }
    vx += kStep * (f - 0.4 * vx) / 2.0;
    x += kStep * vx;
    vq += kStep * (m - 4.0 * std::sin(q) - 0.1 * vq - (vq > 0.0 ? 0.3 : -0.3));
    q += kStep * vq;
  }
  write_file(file, csv);
}

}  // namespace

TEST_CASE("An effect in the second joint of a custom machine is told with its joint and its units", "[report]") {
  const Folder folder;
  record(folder.path() / "train.csv");
  write_file(folder.path() / "spec.yaml", R"(name: slide and pendulum
model:
  plant: custom
  acceleration: ["(u1 - 0.4*v1)/2", "u2 - 4*sin(q2) - 0.1*v2"]
  inertia: ["2", "1"]
signals:
  time: t
  position: [{column: x, unit: m}, {column: q, unit: rad}]
  input: [{column: f, unit: N}, {column: m, unit: N m}]
recordings: [train.csv]
effects: [coulomb_friction, viscous_friction, linear_spring]
)");
  const auto out = folder.path() / "out";
  const CommandResult result = bayesctrl_with({"diagnose", folder.path() / "spec.yaml", "--out", out});
  INFO(result.err);
  REQUIRE(result.status == 0);
  CHECK_THAT(result.out, Contains("coulomb_friction in joint 2") && Contains("N m"));

  const Diagnosis d = read_diagnosis(out / "diagnosis.json");
  CHECK(d.joints == 2);
  CHECK(d.units == std::vector<JointUnits>{{"m", "m/s", "N", "N"}, {"rad", "rad/s", "N m", "N m"}});
  CHECK(to_json(d) == ordered_json::parse(read_file(out / "diagnosis.json", 10'000'000)));
  const ordered_json data = data_of(read_file(out / "report.html", 10'000'000));
  CHECK_THAT(data["sentence"].get<std::string>(), Contains("Coulomb friction in joint 2"));

  const auto truth = [](int joint) {
    return ordered_json{
        {"family", "single"},
        {"plant", "custom"},
        {"noise", 1e-6},
        {"effects",
         {{{"name", "coulomb_friction"}, {"joint", joint}, {"size", 9.0}, {"parameters", {{"level", 0.3}}}}}}};
  };
  const trial::Scored right = trial::score("a", truth(2), d), wrong = trial::score("b", truth(1), d);
  CHECK(right.named);
  CHECK(right.said == "coulomb_friction@2");
  CHECK(wrong.wrong);
}
