// Inventions that a grammar draws: numbers everywhere, memories that stay bounded, no two alike.

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "trial/diagnosed.hpp"
#include "trial/machine_draw.hpp"
#include "trial/score.hpp"

using namespace bayesctrl;

TEST_CASE("Whatever the grammar draws is a torque, its memory stays bounded, and no two are alike", "[trial]") {
  constexpr double kRange = 0.5, kSpeed = 1.5, kInput = 4.0, kDuration = 12.0;
  std::set<double> seen;
  std::set<std::string> causes;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    RandomStream random(seed);
    const trial::Invention drawn = trial::draw_invention(kRange, kSpeed, kInput, kDuration, random);
    INFO(seed << ": " << drawn.name);
    causes.insert(drawn.cause);
    CHECK(drawn.also != drawn.cause);
    double memory = 0.0, sum = 0.0, largest = 0.0;
    constexpr double kStep = 1e-3;
    for (double t = 0.0; t < kDuration; t += kStep) {
      const double q = kRange * std::sin(2.0 * t), v = 2.0 * kRange * std::cos(2.0 * t), u = kInput * std::sin(5.0 * t);
      const double torque = drawn.torque(q, v, u, t, memory);
      REQUIRE(std::isfinite(torque));
      sum += torque * torque * kStep;
      memory += kStep * drawn.rate(q, v, u, memory);
      largest = std::max(largest, std::abs(memory));
    }
    CHECK(largest < 10.0);
    CHECK(seen.insert(sum).second);
  }
  CHECK(causes == std::set<std::string>{"position", "velocity", "input", "time", "history"});
}

TEST_CASE("What the grammar draws is out of the catalogue's reach, and the same whenever it is drawn",
          "[trial][slow]") {
  const TrialSpec spec{.seed = 8, .lowest_noise = 3e-4, .highest_noise = 1e-3};
  const trial::Order order{"grammar_0", "grammar", {}, 0};
  const trial::Case one = trial::make_case(spec, order), same = trial::make_case(spec, order);
  REQUIRE_FALSE(one.files.empty());
  CHECK(one.files == same.files);
  CHECK(one.truth["outside"]["distance"].get<double>() >= 3.0);
  const trial::Scored scored = trial::score("grammar_0", one.truth, testing::diagnosed(one));
  INFO(one.truth.dump(1));
  CHECK(scored.family == "grammar");
  CHECK(scored.detected);
  CHECK_FALSE(scored.confident);
}
