// Effects that depend on a recorded temperature.

#include "physics/temperature.hpp"

#include <catch2/catch.hpp>

#include "diagnose/motion/decimate.hpp"
#include "diagnose/motion/forcing.hpp"
#include "diagnose/motion/operating_range.hpp"
#include "physics/machine/machine.hpp"

using namespace bayesctrl;

namespace {

constexpr double kRounding = 1e-9;
constexpr std::size_t kSamples = 401;

const Pendulum kPendulum{.length = 0.8, .friction = 0.05, .mass = 0.7};
const ThermalFriction kGrease{0.4, 12.0};

RecordedTemperature constant(double celsius) {
  return std::make_shared<const Temperature>(Temperature{{0.0}, Eigen::MatrixXd::Constant(1, 1, celsius)});
}

std::vector<double> times(double period = 0.01) {
  std::vector<double> list;
  for (std::size_t k = 0; k < kSamples; ++k) list.push_back(static_cast<double>(k) * period);
  return list;
}

/// Positions and velocities of a free swing.
Eigen::MatrixXd swing(const Effect& effect, const RecordedTemperature& temperature) {
  const Machine machine(kPendulum, {effect}, {}, temperature);
  const std::vector<double> time = times();
  Eigen::MatrixXd states;
  machine.run(StateVector{{1.2, 0.0}}, time, machine.drives(time, Eigen::MatrixXd::Zero(kSamples, 1)), 0, kSamples - 1,
              0.002, machine.hidden_at_rest(), &states);
  return states;
}

}  // namespace

TEST_CASE("A temperature is linear between its samples and constant beyond", "[effects]") {
  Temperature t{{1.0, 2.0, 4.0}, Eigen::MatrixXd(3, 2)};
  t.celsius << 20.0, 50.0, 30.0, 50.0, 26.0, 40.0;
  for (const auto& [at, expected] :
       {std::pair(-1.0, 20.0), {1.0, 20.0}, {1.5, 25.0}, {2.0, 30.0}, {3.0, 28.0}, {4.0, 26.0}, {9.0, 26.0}}) {
    CHECK(t.at(0, at) == Approx(expected));
  }
  CHECK(t.at(1, 3.5) == Approx(42.5));
}

TEST_CASE("At one temperature thermal friction is viscous friction", "[effects]") {
  for (const double celsius : {-10.0, 20.0, 35.0, 80.0}) {
    const double coefficient = kGrease.coefficient * std::exp((20.0 - celsius) / kGrease.scale);
    const Eigen::MatrixXd warm = swing({kGrease}, constant(celsius)),
                          viscous = swing({ViscousFriction{coefficient}}, {});
    CHECK((warm - viscous).cwiseAbs().maxCoeff() < kRounding);
  }
  CHECK((swing({kGrease}, {}) - swing({ViscousFriction{kGrease.coefficient}}, {})).cwiseAbs().maxCoeff() < kRounding);
}

TEST_CASE("A temperature that rises with the time makes drag fade as that of a machine that warms up", "[effects]") {
  // 20 + 12 t / 1.5 degrees: exp(-(T - 20) / 12) = exp(-t / 1.5).
  const double fades = 1.5, end = times().back();
  Temperature rising{{0.0, end}, Eigen::MatrixXd(2, 1)};
  rising.celsius << 20.0, 20.0 + kGrease.scale * end / fades;
  const Eigen::MatrixXd thermal = swing({kGrease}, std::make_shared<const Temperature>(rising)),
                        warming = swing({WarmingFriction{kGrease.coefficient, fades}}, {});
  CHECK((thermal - warming).cwiseAbs().maxCoeff() < kRounding);
}

TEST_CASE("What thermal friction does along a motion is asked of the recording's temperature", "[effects]") {
  const std::vector<double> time = times();
  const Eigen::MatrixXd states = swing({kGrease}, constant(31.0));
  std::vector<Measured> data(2);
  for (Measured& m : data) {
    m.time = time;
    m.position = states.leftCols(1);
    m.input = Eigen::MatrixXd::Zero(kSamples, 1);
  }
  data[0].temperature = constant(31.0);
  const std::vector<Trajectory> paths = smooth_all(kPendulum, data, Eigen::VectorXd::Constant(1, 1e-5));
  const Forcing forcing(kPendulum, data, paths);
  const double warm = kGrease.coefficient * std::exp((20.0 - 31.0) / kGrease.scale);
  CHECK((forcing.acceleration({kGrease}, 0) - forcing.acceleration({ViscousFriction{warm}}, 0)).norm() < kRounding);
  CHECK((forcing.acceleration({kGrease}, 1) - forcing.acceleration({ViscousFriction{kGrease.coefficient}}, 1)).norm() <
        kRounding);
  CHECK(operating_range(data, paths, 0).coldest == 31.0);
}

TEST_CASE("Of a recording that is thinned the temperature stays", "[effects]") {
  Measured m;
  m.time = times(5e-4);
  m.position = Eigen::MatrixXd::Zero(kSamples, 1);
  m.input = Eigen::MatrixXd::Zero(kSamples, 1);
  m.temperature = constant(44.0);
  const std::vector<Measured> thin = decimated(kPendulum, {m}, Eigen::VectorXd::Constant(1, 1e-3), 200.0);
  REQUIRE(thin[0].samples() < kSamples);
  CHECK(thin[0].temperature == m.temperature);
  CHECK(excerpts({m}, 0.1, 0.05)[0].temperature == m.temperature);
}
