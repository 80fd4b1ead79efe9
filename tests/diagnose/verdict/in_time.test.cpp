#include "diagnose/verdict/in_time.hpp"

#include <catch2/catch.hpp>

#include "physics/catalogue.hpp"
#include "support/recorded_pendulum.hpp"

using namespace bayesctrl;
using testing::kPendulum, testing::kPendulumNoise, testing::record;

namespace {

const Effect kHum{PeriodicDisturbance{}, 0, -1}, kSlides{CoulombFriction{0.1}, 0, -1};

Measured with(std::vector<Effect> effects, std::uint64_t seed) {
  return record(Machine(kPendulum, std::move(effects)), -1.0, seed);
}

Effect jump(int recording) { return {TorqueStep{0.3, 2.0}, 0, recording}; }

std::vector<std::size_t> unconfirmed(std::vector<Effect> effects, std::vector<Measured> data,
                                     std::vector<Measured> held_out = {}) {
  return unconfirmed_in_time({kPendulum, std::move(effects), {}}, {std::move(data), std::move(held_out), kPendulum,
                                                                   Eigen::VectorXd::Constant(1, kPendulumNoise)});
}

using List = std::vector<std::size_t>;

}  // namespace

TEST_CASE("An effect in time is confirmed by a second recording, or by one that was held out", "[diagnose]") {
  const Measured jumps = with({kSlides, {TorqueStep{0.3, 2.0}, 0}}, 0),
                 again = with({kSlides, {TorqueStep{0.3, 2.0}, 0}}, 1);
  const Measured calm = with({kSlides}, 2);
  CHECK(unconfirmed({kSlides, jump(0)}, {jumps, calm}) == List{1});
  CHECK(unconfirmed({kSlides, jump(-1)}, {jumps, again}) == List{});
  CHECK(unconfirmed({kSlides, jump(0)}, {jumps, calm}, {again}) == List{});
  CHECK(unconfirmed({kSlides, jump(0)}, {jumps, calm}, {calm}) == List{1});
  CHECK(unconfirmed({kSlides, jump(-1)}, {jumps, again}, {calm}) == List{1});
  CHECK(unconfirmed({kSlides}, {jumps, calm}) == List{});
}

TEST_CASE("What repeats is confirmed within one recording, and contradicted by another", "[diagnose]") {
  CHECK(unconfirmed({kHum}, {with({kHum}, 0)}) == List{});
  CHECK(unconfirmed({kHum}, {with({}, 0)}) == List{0});
  CHECK(unconfirmed({kHum}, {with({kHum}, 0)}, {with({}, 1)}) == List{0});
}
