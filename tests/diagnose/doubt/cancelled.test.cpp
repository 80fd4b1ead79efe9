#include "diagnose/doubt/cancelled.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "physics/catalogue.hpp"

using namespace bayesctrl;

namespace {

/// A joint that swings by a radian twice in a second.
std::vector<Measured> swing() {
  Measured m;
  m.position.resize(1000, 1);
  m.input = Eigen::MatrixXd::Zero(1000, 1);
  for (int k = 0; k < 1000; ++k) {
    m.time.push_back(0.01 * k);
    m.position(k, 0) = std::sin(12.0 * 0.01 * k) + 0.4 * std::sin(5.0 * 0.01 * k);
  }
  return {m};
}

std::optional<Cancelled> undone_by(const Plant& plant, std::vector<Effect> effects) {
  Fit fit;
  fit.plant = plant;
  fit.effects = std::move(effects);
  return cancelled(fit, swing());
}

}  // namespace

TEST_CASE("Effects that undo the plant's friction or gravity are known, alone and beside others", "[doubt]") {
  const Pendulum pendulum{.length = 1.0, .friction = 3.0, .mass = 1.0};
  const Effect undoes{ViscousFriction{-3.0}};
  CHECK_FALSE(undone_by(pendulum, {}));
  REQUIRE(undone_by(pendulum, {undoes}));
  CHECK(undone_by(pendulum, {undoes})->of_speed);
  CHECK(undone_by(pendulum, {undoes, Effect{CoulombFriction{1.0}}})->of_speed);
  CHECK(undone_by(pendulum, {Effect{ViscousFriction{-2.0}}, Effect{ViscousFriction{-1.0}}})->of_speed);
  CHECK_FALSE(undone_by(pendulum, {Effect{ViscousFriction{-2.0}}}));
  CHECK_FALSE(undone_by(pendulum, {Effect{CoulombFriction{1.0}}}));
  const Custom spring({{{"k", 100.0}}}, {"u - k*q"}, {});
  REQUIRE(undone_by(spring, {Effect{LinearSpring{-100.0}}}));
  CHECK_FALSE(undone_by(spring, {Effect{LinearSpring{-100.0}}})->of_speed);
  CHECK_FALSE(undone_by(spring, {Effect{LinearSpring{-80.0}}}));
}

TEST_CASE("A term that hardly matters may be undone", "[doubt]") {
  CHECK_FALSE(undone_by(Pendulum{.friction = 1e-3}, {Effect{ViscousFriction{-1e-3}}}));
}
