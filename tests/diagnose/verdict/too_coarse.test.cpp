// Recordings of which samples may be left out for the nominal, but not for what the nominal lacks.

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;

namespace {

constexpr double kLoad = 0.15;  // friction over load

/// A slide whose dry friction grows with the load, by Heun steps of 0.1 ms. Sampled at 1 kHz; the input shakes as that
/// of a controller does which differentiates a noisy position: of its size within some samples the mean knows nothing.
std::string recorded(std::uint64_t seed, double duration) {
  constexpr double kSample = 1e-3, kNoise = 2e-4, kDrag = 0.3;
  constexpr int kSteps = 10;
  RandomStream random(seed);
  std::array<double, 3> phase{};
  for (double& p : phase) p = draw_uniform(random, 0.0, 6.28);
  std::string csv = "t,q,u\n";
  double q = 0.0, v = 0.0;
  for (int k = 0; kSample * k < duration; ++k) {
    const double t = kSample * k;
    const double u = 2.0 * std::sin(2.0 * t + phase[0]) + 1.5 * std::sin(5.3 * t + phase[1]) +
                     std::sin(9.1 * t + phase[2]) - 1.5 * q + 2.0 * draw_normal(random);
    char row[64];
    std::snprintf(row, sizeof row, "%.3f,%.7f,%.5f\n", t, q + kNoise * draw_normal(random), u);
    csv += row;
    for (int i = 0; i < kSteps; ++i) {
      const double h = kSample / kSteps, most = kLoad * std::abs(u);
      const double direction = (v != 0.0 ? v : u) > 0.0 ? 1.0 : -1.0;
      const bool sticks = v == 0.0 && std::abs(u) <= most;
      const auto acceleration = [&](double speed) { return sticks ? 0.0 : u - kDrag * speed - most * direction; };
      const double ahead = v + h * acceleration(v);
      double next = v + 0.5 * h * (acceleration(v) + acceleration(ahead));
      if (v * next < 0.0) next = 0.0;
      q += 0.5 * h * (v + next);
      v = next;
    }
  }
  return csv;
}

}  // namespace

TEST_CASE("Friction under a load that shakes faster than the machine moves is told from whole recordings",
          "[diagnose][slow]") {
  const io_examples::Folder folder;
  for (int i = 1; i <= 3; ++i) {
    write_file(folder.path() / ("run" + std::to_string(i) + ".csv"), recorded(static_cast<std::uint64_t>(i), 6.0));
  }
  write_file(folder.path() / "spec.yaml",
             "name: shaken\nmodel: {plant: mass, parameters: {mass: 1, friction: 0.3}}\n"
             "signals: {time: t, position: q, input: u}\nrecordings: [run1.csv, run2.csv]\nheld_out: [run3.csv]\n");
  const Diagnosis d = diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
  CHECK(d.verdict == Verdict::named);  // thinned out, dry friction of a constant level would stand beside it
  REQUIRE(d.explanation.effects.size() == 1);
  CHECK(d.explanation.effects[0].name == "load_dependent_friction");
  CHECK(d.explanation.effects[0].parameters.find("k")->value == Approx(kLoad).epsilon(0.01));
  CHECK(d.fit.held_out.after.value() < 1.1 * d.fit.noise_floor);
}
