// What differs from recording to recording: a zero that was set anew, a weaker supply, the temperature. Integrated
// here, independently.

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <sstream>

#include "base/random.hpp"
#include "diagnose/verdict/diagnose.hpp"
#include "diagnose/verdict/sentence.hpp"
#include "io/files.hpp"
#include "io/folder.hpp"

using namespace bayesctrl;

namespace {

constexpr double kSeen = 2e-4;  // rad, of noise

/// What is not as the nominal says in one recording.
struct Peculiar {
  double offset = 0.0, gain = 1.0;
  double begin = 20.0, end = 20.0;  // degrees Celsius
};

/// 12 s at 100 Hz of 0.36 q'' = gain u - 0.1 v - 4 sin q - 0.3 exp(-(T - 20)/15) v where greased, by midpoint steps of
/// 0.1 ms.
std::string swinging(const Peculiar& how, bool greased, std::uint64_t seed) {
  constexpr int kSteps = 100;
  constexpr double kPeriod = 0.01, kStep = kPeriod / kSteps, kSeconds = 12.0;
  RandomStream random(seed);
  const double phase = draw_uniform(random, 0.0, 6.0);
  std::ostringstream csv;
  csv.precision(10);
  csv << "t,q,u,T\n";
  double q = 0.2, v = 0.0;
  for (int k = 0; k < 1200; ++k) {
    const double t = kPeriod * k, celsius = how.begin + (how.end - how.begin) * t / kSeconds;
    const double u = 2.0 * std::sin(1.1 * t + phase) + 1.2 * std::sin(3.7 * t) + 0.8 * std::sin(7.9 * t + phase);
    csv << t << "," << q + how.offset + kSeen * draw_normal(random) << "," << u << "," << celsius << "\n";
    const double drag = 0.1 + (greased ? 0.3 * std::exp((20.0 - celsius) / 15.0) : 0.0);
    const auto rate = [&](double at, double speed) {
      return (how.gain * u - drag * speed - 0.6 * 9.81 * 0.6 * std::sin(at)) / (0.6 * 0.6 * 0.6);
    };
    for (int i = 0; i < kSteps; ++i) {
      const double middle = v + 0.5 * kStep * rate(q, v);
      v += kStep * rate(q + 0.5 * kStep * v, middle);
      q += kStep * middle;
    }
  }
  return csv.str();
}

/// The last one is held out.
Diagnosed diagnosed_of(const std::vector<Peculiar>& recordings, bool greased, const std::string& signals,
                       const std::string& effects) {
  const io_examples::Folder folder;
  std::string train;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    write_file(folder.path() / (std::to_string(r) + ".csv"), swinging(recordings[r], greased, r + 1));
    if (r + 1 < recordings.size()) train += (r > 0 ? ", " : "") + std::to_string(r) + ".csv";
  }
  write_file(folder.path() / "spec.yaml",
             "name: one\nmodel: {plant: pendulum, parameters: {length: 0.6, friction: 0.1, mass: 0.6}}\n"
             "signals: {time: t, position: q, input: u" +
                 signals + "}\nrecordings: [" + train + "]\nheld_out: " + std::to_string(recordings.size() - 1) +
                 ".csv\n" + effects);
  return diagnose(read_diagnosis_spec(folder.path() / "spec.yaml"));
}

double value_of(const ExplainedEffect& effect, std::string_view name) { return effect.parameters.find(name)->value; }

}  // namespace

TEST_CASE("Another zero and another strength in one recording each are found there, and are no part of the machine",
          "[diagnose][slow]") {
  const Diagnosed found = diagnosed_of({{}, {.offset = 0.08}, {.gain = 0.85}, {}}, true, "",
                                       "effects: [usual, recording_offset, recording_gain]\n");
  const Diagnosis& d = found.diagnosis;
  INFO(to_json(d).dump(1));
  CHECK(d.verdict == Verdict::named);
  int seen = 0;
  for (const ExplainedEffect& effect : d.explanation.effects) {
    if (effect.name == "recording_offset" && effect.recording == "1.csv") {
      ++seen;
      CHECK(value_of(effect, "angle") == Approx(0.08).margin(0.002));
    } else if (effect.name == "recording_gain" && effect.recording == "2.csv") {
      ++seen;
      CHECK(value_of(effect, "gain") == Approx(0.85).margin(0.01));
    } else {
      CHECK(effect.name == "viscous_friction");
    }
  }
  CHECK(seen == 2);
  REQUIRE(found.model["model"]["effects"].size() == 1);
  CHECK(found.model["model"]["effects"][0]["type"] == "viscous_friction");
  REQUIRE(d.fit.held_out.after);
  CHECK(*d.fit.held_out.after < 1.2 * d.fit.noise_floor);
  CHECK_THAT(sentence(d), Catch::Contains("recording offset of 1.csv"));
}

TEST_CASE("Zeros that were set anew before two recordings of three are both found", "[diagnose][slow]") {
  const Diagnosis d =
      diagnosed_of({{}, {.offset = 0.08}, {.offset = -0.06}, {}}, false, "", "effects: [usual, recording_offset]\n")
          .diagnosis;
  INFO(to_json(d).dump(1));
  CHECK(d.verdict == Verdict::named);
  REQUIRE(d.explanation.effects.size() == 2);
  for (const ExplainedEffect& effect : d.explanation.effects) {
    CHECK(effect.name == "recording_offset");
    CHECK(value_of(effect, "angle") == Approx(effect.recording == "1.csv" ? 0.08 : -0.06).margin(0.002));
  }
  CHECK(d.explanation.effects[0].recording != d.explanation.effects[1].recording);
  for (const char* name : {"recording_offset@1#2", "recording_offset@1#3"}) {
    REQUIRE(d.inclusion.find(name) != nullptr);
    CHECK(*d.inclusion.find(name) > 0.9);
    CHECK(*d.inclusion.find(name) <= 1.0 + 1e-9);
  }
}

TEST_CASE("Drag that falls with a recorded temperature is named without being asked for", "[diagnose][slow]") {
  const std::vector<Peculiar> warming{
      {.begin = 18.0, .end = 30.0}, {.begin = 28.0, .end = 45.0}, {.begin = 15.0, .end = 40.0}};
  const Diagnosis d = diagnosed_of(warming, true, ", temperature: {column: T, unit: degC}", "").diagnosis;
  INFO(to_json(d).dump(1));
  CHECK(d.verdict == Verdict::named);
  REQUIRE(d.explanation.effects.size() == 1);
  const ExplainedEffect& effect = d.explanation.effects[0];
  CHECK(effect.name == "thermal_friction");
  CHECK(value_of(effect, "coefficient") == Approx(0.3).margin(0.01));
  CHECK(value_of(effect, "scale") == Approx(15.0).margin(0.6));

  const Diagnosis none = diagnosed_of(warming, false, ", temperature: T", "").diagnosis;
  CHECK(none.verdict == Verdict::nothing_missing);
}
