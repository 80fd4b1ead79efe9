// Long recordings, and those with long gaps: searched in excerpts, in the memory of a short one, and named the same.

#include <sys/resource.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/runge_kutta.hpp"
#include "support/sanitized.hpp"

using namespace bayesctrl;

namespace {

/// A pendulum with dry friction and a disturbance of a fixed frequency, by Runge-Kutta steps of 2 ms of its own
/// equations; sampled at 50 Hz with noise. No samples are there from `gap` on for `lost` seconds.
std::string recorded(double duration, double gap, double lost) {
  const double length = 0.8, mass = 0.6, drag = 0.2, level = 0.15, amplitude = 0.05, frequency = 13.37, h = 0.002;
  const auto input = [](double t) {
    return 2.5 * std::sin(1.1 * t) + 1.5 * std::sin(3.7 * t + 0.3 * std::sin(0.05 * t)) + std::sin(0.13 * t);
  };
  RandomStream random(2);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u\n";
  std::array<double, 2> x{0.3, 0.0};  // q, v
  for (int k = 0; 0.02 * k < duration; ++k) {
    const double t = 0.02 * k, u = input(t);
    if (t < gap || t >= gap + lost) csv << t << "," << x[0] + 3e-4 * draw_normal(random) << "," << u << "\n";
    for (int i = 0; i < 10; ++i) {
      x = testing::runge_kutta_step(x, h, [&](const std::array<double, 2>& s, double since) {
        const double shaking = amplitude * std::sin(frequency * (t + h * i + since) + 1.0);
        const double friction = drag * s[1] + level * std::tanh(s[1] / 1e-3);
        const double torque = u - friction - mass * 9.81 * length * std::sin(s[0]) + shaking;
        return std::array<double, 2>{s[1], torque / (mass * length * length)};
      });
    }
  }
  return csv.str();
}

Diagnosis diagnosed(const std::string& csv) {
  const io_examples::Folder folder;
  write_file(folder.path() / "run.csv", csv);
  write_file(folder.path() / "spec.yaml",
             "name: long\nmodel: {plant: pendulum, parameters: {length: 0.8, friction: 0.2, mass: 0.6}}\n"
             "signals: {time: t, position: q, input: u}\nrecordings: [run.csv]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

void check_friction_and_disturbance(const Diagnosis& d) {
  REQUIRE(d.explanation.effects.size() == 2);
  for (const ExplainedEffect& found : d.explanation.effects) {
    CAPTURE(found.name);
    if (found.name == "coulomb_friction") {
      CHECK(found.parameters.find("level")->value == Approx(0.15).epsilon(0.02));
    } else {
      CHECK(found.name == "periodic_disturbance");
      CHECK(found.parameters.find("amplitude")->value == Approx(0.05).epsilon(0.05));
      CHECK(found.parameters.find("frequency")->value == Approx(13.37).epsilon(1e-3));
    }
  }
}

}  // namespace

TEST_CASE("Ten minutes of a machine are diagnosed in the memory of excerpts", "[diagnose][slow]") {
  const Diagnosis d = diagnosed(recorded(600.0, 1e9, 0.0));
  CHECK(d.verdict == Verdict::named);
  check_friction_and_disturbance(d);
  CHECK(*d.fit.recorded == Approx(600.0).epsilon(0.01));
  CHECK(*d.fit.searched == Approx(90.0).epsilon(0.05));
  rusage used{};
  getrusage(RUSAGE_SELF, &used);
  if (!kSanitized) CHECK(used.ru_maxrss < 700'000);  // kB
}

TEST_CASE("A first stamp of 0 before those of a clock of the world is a gap, not two thousand million seconds",
          "[diagnose][slow]") {
  std::string csv = "t,q,u\n0,0.3,0\n";
  std::istringstream rows(recorded(24.0, 1e9, 0.0));
  std::string line;
  std::getline(rows, line);
  while (std::getline(rows, line)) {
    const std::size_t comma = line.find(',');
    char stamp[32];
    std::snprintf(stamp, sizeof stamp, "%.2f", 1.7e9 + std::stod(line.substr(0, comma)));
    csv += stamp + line.substr(comma) + "\n";
  }
  const Diagnosis d = diagnosed(csv);
  REQUIRE_FALSE(d.explanation.effects.empty());
  CHECK(d.explanation.effects[0].name == "coulomb_friction");
}

TEST_CASE("A gap of a quarter of an hour costs nothing and changes no name", "[diagnose][slow]") {
  const Diagnosis d = diagnosed(recorded(924.0, 12.0, 900.0));
  CHECK(d.verdict == Verdict::named);
  check_friction_and_disturbance(d);
  CHECK(*d.fit.recorded == Approx(24.0).epsilon(0.01));
}
