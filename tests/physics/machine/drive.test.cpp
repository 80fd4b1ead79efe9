// What thinned inputs hold beside their mean.

#include "physics/machine/drive.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"
#include "physics/catalogue.hpp"

using namespace bayesctrl;

namespace {

constexpr Eigen::Index kStaying = 6;
constexpr int kRowsEach = 4;  // that each sample stands for

/// Rows of an input at random, each in part handed on to the next sample.
FineInput drawn(RandomStream& random) {
  FineInput fine;
  fine.input = Eigen::MatrixXd(kStaying * kRowsEach, 1);
  for (Eigen::Index k = 0; k < fine.input.rows(); ++k) {
    fine.input(k, 0) = draw_normal(random);
    const double handed = k / kRowsEach + 1 < kStaying ? 0.08 * (static_cast<double>(k % kRowsEach) - 1.5) : 0.0;
    fine.stays.push_back(k / kRowsEach);
    fine.own.push_back(1.0 / kRowsEach - handed);
    fine.late.push_back(handed);
  }
  return fine;
}

}  // namespace

TEST_CASE("What an input does to a load beside its mean is that of the rows a sample stands for", "[physics]") {
  RandomStream random(4);
  const FineInput fine = drawn(random);
  const InputSpread spread(fine, fine.input.col(0), kStaying);
  const Eigen::VectorXd mean = fine.held(fine.input.col(0), kStaying);
  int steady = 0;
  for (const double from : {-3.5, -0.6, 0.0, 0.3, 1.2, 3.5}) {
    const Eigen::VectorXd distance = fine.held((fine.input.col(0).array() - from).abs(), kStaying);
    for (Eigen::Index i = 0; i < kStaying; ++i) {
      const double expected = std::max(0.0, distance[i] - std::abs(mean[i] - from));
      CHECK(spread.unsteady(static_cast<std::size_t>(i), from) == Approx(expected).margin(1e-14));
      steady += expected < 1e-14 ? 1 : 0;
    }
  }
  CHECK(steady > 12);  // from beyond all of them
  CHECK(steady < 30);
  CHECK(spread.unsteady(kStaying, 0.0) == 0.0);
  CHECK(InputSpread().unsteady(0, 0.0) == 0.0);
}

TEST_CASE("A drive knows that spread of its own segments, behind maps and delays, where a load asks for it",
          "[physics]") {
  RandomStream random(5);
  const FineInput fine = drawn(random);
  std::vector<double> time, mean;
  for (Eigen::Index i = 0; i < kStaying; ++i) time.push_back(0.1 * static_cast<double>(i));
  for (const double u : fine.held(fine.input.col(0), kStaying)) mean.push_back(u);
  const InputSpread doubled(fine, 2.0 * fine.input.col(0), kStaying);
  const Effect load{LoadDependentFriction{0.2}, 0}, gain{InputGain{2.0}, 0}, delay{InputDelay{0.03}, 0};
  for (const bool late : {false, true}) {
    std::vector<Effect> effects{load, gain};
    if (late) effects.push_back(delay);
    const Drive drive(time, mean, effects, 0, &fine);
    for (std::size_t i = 0; i < time.size(); ++i) {
      CHECK(drive.unsteady(i + (late ? 1 : 0), 0.1) == doubled.unsteady(i, 0.1));
    }
    if (late) CHECK(drive.unsteady(0, 0.1) == 0.0);
  }
  for (const std::vector<Effect>& effects :
       {std::vector<Effect>{gain}, {load, {ActuatorLag{0.05}, 0}}, {{LoadDependentFriction{0.2}, 1}}}) {
    const Drive drive(time, mean, effects, 0, &fine);
    for (std::size_t i = 0; i < time.size(); ++i) CHECK(drive.unsteady(i, 0.1) == 0.0);
  }
}
