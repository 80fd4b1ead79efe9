// How results are shown: in the recordings' own time and with the fit's numbers, each in its place.

#include "diagnose/verdict/present.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum;

namespace {

/// Two recordings of two joints whose numbers all differ.
std::vector<Measured> numbered_recordings() {
  std::vector<Measured> data{
      {"a.csv", {0.0, 0.1, 0.2}, Eigen::MatrixXd(3, 2), Eigen::MatrixXd::Zero(3, 2), 10.0, false},
      {"b.csv", {0.0, 0.5}, Eigen::MatrixXd(2, 2), Eigen::MatrixXd::Zero(2, 2), -4.0, false}};
  double next = 100.0;
  for (Measured& m : data) {
    for (double& x : m.position.reshaped()) x = next++;
  }
  return data;
}

const std::vector<JointUnits> kSlideAndHinge{{"m", "m/s", "N", "V"}, {"rad", "rad/s", "N m", "A"}};

Cell cell(const Table& table, std::string_view name, std::size_t row) {
  REQUIRE(table.find(name) != nullptr);
  return table.find(name)->at(row);
}

}  // namespace

TEST_CASE("Intervals are shown in the time of their own recording, shares to six decimals", "[diagnose][present]") {
  const std::vector<TimeSpan> spans = shown({{1, 0.1, 0.4, 7.0}, {0, 0.0, 0.2, 3.0}}, numbered_recordings());
  REQUIRE(spans.size() == 2);
  CHECK(spans[0].recording == "b.csv");
  CHECK(spans[0].from == Approx(-3.9));
  CHECK(spans[0].to == Approx(-3.6));
  CHECK(spans[0].score == 7.0);
  CHECK(spans[1].from == Approx(10.0));
  const CauseShares shares = shown(Shares{0.12345678, 0.5, 0.0, 0.3765432, 1e-7});
  CHECK(shares.of == decltype(shares.of){0.123457, 0.5, 0.0, 0.376543, 0.0});
  CHECK(shares.leading() == Cause::velocity);
}

TEST_CASE("An effect is shown with its values, their deviations and the recording in which it is",
          "[diagnose][present]") {
  Fit fit;
  fit.plant = Pendulum{.length = 0.8, .friction = 0.3, .mass = 0.6};
  fit.effects = {{CoulombFriction{0.25}, 1, -1}, {TorqueStep{-0.5, 2.0}, 0, 1}};
  fit.unknowns = {{-1, "friction"}, {0, "level"}, {1, "torque"}};
  fit.covariance = Eigen::Vector3d(1e-4, 4e-4, 9e-4).asDiagonal();
  const std::vector<Measured> data = numbered_recordings();
  const ExplainedEffect friction = shown_effect(fit, 0, data, kSlideAndHinge),
                        step = shown_effect(fit, 1, data, kSlideAndHinge);
  CHECK(friction.name == "coulomb_friction");
  CHECK(friction.joint == 2);
  CHECK(!friction.recording);
  CHECK(friction.parameters.items[0].second.value == 0.25);
  CHECK(friction.parameters.items[0].second.sd == Approx(0.02));
  CHECK(step.joint == 1);
  CHECK(step.recording == "b.csv");
  CHECK(step.parameters.items[0].second.value == -0.5);
  CHECK(step.parameters.items[0].second.sd == Approx(0.03));
  CHECK(step.parameters.items[1].second.sd == 0.0);
  const NominalParameter nominal = shown_parameter(kPendulum, fit, "friction", true, kSlideAndHinge[1]);
  CHECK(nominal.nominal == 0.2);
  CHECK(nominal.value == 0.3);
  CHECK(nominal.sd == Approx(0.01));
  CHECK(equation(fit.effects, 2) == "joint 2: torque -= 0.25 sign(v); joint 1: torque -= 0.5 from t = 2 s on");
}

TEST_CASE("Tables hold every sample of every recording and joint in its place", "[diagnose][present]") {
  const std::vector<Measured> data = numbered_recordings();
  std::vector<Trajectory> smoothed;
  std::vector<Eigen::MatrixXd> law;
  FreeRuns before, after;
  for (const Measured& m : data) {
    const Eigen::MatrixXd& x = m.position;
    smoothed.push_back({(x.array() + 1e3).matrix(), (x.array() + 2e3).matrix(), (x.array() + 3e3).matrix(), x,
                        (x.array() + 4e3).matrix()});
    law.push_back((x.array() + 7e3).matrix());
    before.simulated.push_back((x.array() + 5e3).matrix());
    after.simulated.push_back((x.array() + 6e3).matrix());
  }
  const Table torque = torque_table(data, smoothed, law, kSlideAndHinge);
  Table runs;
  add_runs(runs, "train", data, before, after, kSlideAndHinge);
  add_runs(runs, "held_out", data, before, after, kSlideAndHinge);
  REQUIRE(torque.rows() == 5);
  REQUIRE(runs.rows() == 10);
  CHECK(torque.find("torque1")->unit == "N");
  CHECK(torque.find("torque2")->unit == "N m");
  std::size_t row = 0;
  for (const Measured& m : data) {
    for (Eigen::Index k = 0; k < m.position.rows(); ++k, ++row) {
      CHECK(cell(torque, "recording", row) == Cell(m.name));
      CHECK(cell(torque, "t", row) == Cell(m.start + m.time[static_cast<std::size_t>(k)]));
      CHECK(cell(runs, "set", row) == Cell(std::string("train")));
      CHECK(cell(runs, "set", row + 5) == Cell(std::string("held_out")));
      for (Eigen::Index j = 0; j < 2; ++j) {
        const std::string joint = std::to_string(j + 1);
        const double x = m.position(k, j);
        CHECK(cell(torque, "q" + joint, row) == Cell(x + 1e3));
        CHECK(cell(torque, "v" + joint, row) == Cell(x + 2e3));
        CHECK(cell(torque, "torque" + joint, row) == Cell(x + 3e3));
        CHECK(cell(torque, "sd" + joint, row) == Cell(x + 4e3));
        CHECK(cell(torque, "law" + joint, row) == Cell(x + 7e3));
        CHECK(cell(torque, "u" + joint, row) == Cell(m.input(k, j)));
        CHECK(cell(runs, "measured" + joint, row + 5) == Cell(x));
        CHECK(cell(runs, "before" + joint, row) == Cell(x + 5e3));
        CHECK(cell(runs, "after" + joint, row) == Cell(x + 6e3));
      }
    }
  }
}
