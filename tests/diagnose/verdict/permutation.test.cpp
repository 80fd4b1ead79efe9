// What is said of a machine depends neither on the order of its recordings nor on how its joints are numbered.

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"
#include "support/runge_kutta.hpp"

using namespace bayesctrl;

namespace {

/// Two masses (1 and 2 kg) on a spring of 12 N/m between them, by Runge-Kutta steps of 1 ms; the first has a spring of
/// its own, the second dry friction. Columns t, q1, q2, u1, u2 at 50 Hz for 10 s.
std::string recorded(double start, std::uint64_t seed) {
  constexpr double kStep = 1e-3;
  RandomStream random(seed);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q1,q2,u1,u2\n";
  std::array<double, 4> x{start, -0.5 * start, 0.0, 0.0};  // q1, q2, v1, v2
  for (int k = 0; k < 500; ++k) {
    const double t = 0.02 * k, u1 = 3.0 * std::sin(1.7 * t + start), u2 = 4.0 * std::sin(2.9 * t) + std::sin(0.7 * t);
    csv << t << "," << x[0] + 5e-4 * draw_normal(random) << "," << x[1] + 5e-4 * draw_normal(random) << "," << u1 << ","
        << u2 << "\n";
    for (int i = 0; i < 20; ++i) {
      x = testing::runge_kutta_step(x, kStep, [&](const std::array<double, 4>& s, double /*t*/) {
        const double between = 12.0 * (s[0] - s[1]);
        return std::array<double, 4>{s[2], s[3], u1 - between - 0.3 * s[2] - 4.0 * s[0],
                                     0.5 * (u2 + between - 0.3 * s[3] - 0.6 * std::tanh(s[3] / 1e-3))};
      });
    }
  }
  return csv.str();
}

/// With mass number `first` (1 or 2) as joint 1.
Diagnosis diagnosed(const std::vector<std::uint64_t>& seeds, int first) {
  const io_examples::Folder folder;
  std::string files;
  for (const std::uint64_t seed : seeds) {
    const std::string file = "r" + std::to_string(seed) + ".csv";
    write_file(folder.path() / file, recorded(0.2 + 0.3 * static_cast<double>(seed), seed));
    files += (files.empty() ? "" : ", ") + file;
  }
  const std::string a = std::to_string(first), b = std::to_string(3 - first);
  const std::string heavy1 = first == 1 ? "1" : "0.5", heavy2 = first == 1 ? "0.5" : "1";
  write_file(folder.path() / "spec.yaml",
             "name: two\nmodel: {plant: custom, parameters: {k: 12, d: 0.3}, acceleration: [\"" + heavy1 +
                 "*(u1 - k*(q1 - q2) - d*v1)\", \"" + heavy2 +
                 "*(u2 + k*(q1 - q2) - d*v2)\"]}\n"
                 "signals: {time: t, position: [q" +
                 a + ", q" + b + "], input: [u" + a + ", u" + b +
                 "]}\n"
                 "recordings: [" +
                 files + "]\n");
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml")).diagnosis;
}

/// Value of the first parameter and its deviation by the effect and the number of the mass.
std::map<std::string, Estimate> found(const Diagnosis& d, int first) {
  std::map<std::string, Estimate> result;
  for (const ExplainedEffect& effect : d.explanation.effects) {
    const int mass = effect.joint == 1 ? first : 3 - first;
    result.emplace(effect.name + std::to_string(mass), effect.parameters.items.front().second);
  }
  return result;
}

}  // namespace

TEST_CASE("The order of recordings and the numbering of joints change nothing that is said", "[diagnose][slow]") {
  const Diagnosis reference = diagnosed({1, 2, 3}, 1);
  const std::map<std::string, Estimate> expected = found(reference, 1);
  CHECK(reference.verdict == Verdict::named);
  REQUIRE(expected.size() == 2);
  CHECK(expected.contains("linear_spring1"));
  CHECK(expected.contains("coulomb_friction2"));
  for (const auto& [seeds, first] :
       {std::pair{std::vector<std::uint64_t>{3, 1, 2}, 1}, {{1, 2, 3}, 2}, {{2, 3, 1}, 2}}) {
    INFO("recordings from " << seeds.front() << ", joint 1 is mass " << first);
    const Diagnosis d = diagnosed(seeds, first);
    CHECK(d.verdict == reference.verdict);
    CHECK(d.explanation.probability == Approx(reference.explanation.probability).margin(0.02));
    CHECK(*d.fit.train.after == Approx(*reference.fit.train.after).epsilon(1e-3));
    const std::map<std::string, Estimate> names = found(d, first);
    REQUIRE(names.size() == expected.size());
    for (const auto& [name, estimate] : names) {
      INFO(name);
      REQUIRE(expected.contains(name));
      CHECK(std::abs(estimate.value - expected.at(name).value) < 0.1 * expected.at(name).sd);
    }
  }
}
