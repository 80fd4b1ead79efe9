// Machines that are told a position or fed with a voltage: their drive's unknown numbers are free parameters of a
// custom model, and what is concealed beside them is named. Integrated here, independently.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;

namespace {

constexpr double kDrivenNoise = 1e-4;  // rad

/// 10 s at 100 Hz of q'' = drive(q, v, u) - level sign v, by semi-implicit steps of 20 us.
std::string driven(const std::function<double(double q, double v, double u)>& drive, double level, std::uint64_t seed) {
  constexpr double kStep = 2e-5, kPeriod = 0.01;
  RandomStream random(seed);
  const double phase = draw_uniform(random, 0.0, 6.0);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u\n";
  double t = 0.0, q = 0.1, v = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const double at = kPeriod * k;
    const double u = 0.8 * std::sin(1.3 * at + phase) + 0.4 * std::sin(4.1 * at) + 0.2 * std::sin(11.0 * at + phase);
    csv << at << "," << q + kDrivenNoise * draw_normal(random) << "," << u << "\n";
    for (; t < kPeriod * (k + 1) - 0.5 * kStep; t += kStep) {
      const double force = drive(q, v, u);
      if (v == 0.0 && std::abs(force) <= level) continue;
      const double next = v + kStep * (force - std::copysign(level, v != 0.0 ? v : force));
      v = v * next < 0.0 ? 0.0 : next;
      q += kStep * v;
    }
  }
  return csv.str();
}

Diagnosis diagnosed(const std::string& model, const std::function<double(double, double, double)>& drive,
                    double level) {
  const io_examples::Folder folder;
  for (const int k : {1, 2, 3}) {
    write_file(folder.path() / (std::to_string(k) + ".csv"), driven(drive, level, static_cast<std::uint64_t>(k)));
  }
  write_file(folder.path() / "spec.yaml",
             "name: driven\nmodel: {plant: custom, " + model +
                 "}\nsignals: {time: t, position: q, input: u}\nrecordings: [1.csv, 2.csv]\nheld_out: 3.csv\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

/// Dry friction alone is named, or nothing is missing.
void check_friction(const Diagnosis& diagnosis, bool rubs) {
  CHECK(diagnosis.verdict == (rubs ? Verdict::named : Verdict::nothing_missing));
  REQUIRE(diagnosis.explanation.effects.size() == (rubs ? 1 : 0));
  if (rubs) CHECK(diagnosis.explanation.effects[0].name == "coulomb_friction");
}

void check_parameter(const Diagnosis& diagnosis, const std::string& name, double truth) {
  for (const auto& [found, parameter] : diagnosis.parameters.items) {
    if (found != name) continue;
    INFO(name << " = " << parameter.value << " +- " << parameter.sd);
    CHECK(parameter.value == Approx(truth).epsilon(0.03));
    return;
  }
  FAIL(name << " is not reported");
}

}  // namespace

TEST_CASE("The gains of a position servo and the dry friction behind it are found together", "[diagnose][slow]") {
  const double level = GENERATE(0.0, 3.0);
  const Diagnosis diagnosis = diagnosed(
      "parameters: {k: 250, b: 10}, acceleration: [\"k*(u - q) - b*v\"], free: [k, b]",
      [](double q, double v, double u) { return 160.0 * (u - q) - 14.0 * v; }, level);
  CAPTURE(level);
  INFO(to_json(diagnosis).dump(1));
  check_friction(diagnosis, level > 0.0);
  check_parameter(diagnosis, "k", 160.0);
  check_parameter(diagnosis, "b", 14.0);
}

TEST_CASE(
    "The winding's resistance and the back-EMF of a motor fed with volts, and the dry friction behind them, are "
    "found together",
    "[diagnose][slow]") {
  // u volts, i = (u - K v) / R, torque K i, on an inertia of 2e-3 kg m^2.
  const double level = GENERATE(0.0, 0.5);
  const Diagnosis diagnosis = diagnosed(
      "parameters: {J: 2e-3, K: 0.06, R: 1.5}, acceleration: [\"K*(u - K*v)/R/J\"], free: [K, R]",
      [](double, double v, double u) { return 0.08 * (u - 0.08 * v) / 2.5 / 2e-3; }, level);
  CAPTURE(level);
  INFO(to_json(diagnosis).dump(1));
  check_friction(diagnosis, level > 0.0);
  check_parameter(diagnosis, "K", 0.08);
  check_parameter(diagnosis, "R", 2.5);
}
