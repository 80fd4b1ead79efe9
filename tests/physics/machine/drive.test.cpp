// What a machine feels of an input: what thinned ones hold beside their mean, plays and delays where it begins anew.

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

TEST_CASE("After a gap a delayed input is what comes, and every segment knows the sample that it holds", "[physics]") {
  RandomStream random(6);
  const FineInput fine = drawn(random);
  const std::vector<double> time{0.0, 0.1, 0.2, 1.0, 1.1, 1.2};
  const Eigen::VectorXd held = fine.held(fine.input.col(0), kStaying);
  const std::vector<double> mean(held.begin(), held.end());
  const InputSpread spread(fine, fine.input.col(0), kStaying);
  const std::vector<Effect> effects{{LoadDependentFriction{0.2}, 0}, {InputDelay{0.03}, 0}};
  const Drive drive(time, mean, effects, 0, &fine, {{0, {}}, {3, {}}});
  const std::vector<double> begins{0.0, 0.03, 0.13, 0.23, 1.0, 1.03, 1.13, 1.23};
  const std::vector<int> holds{-1, 0, 1, 2, 3, 3, 4, 5};
  REQUIRE(drive.switches().size() == begins.size());
  for (std::size_t i = 0; i < begins.size(); ++i) {
    const auto sample = static_cast<std::size_t>(holds[i]);
    CHECK(drive.switches()[i] == Approx(begins[i]));
    CHECK(drive.at(i, begins[i]) == (holds[i] < 0 ? 0.0 : held[holds[i]]));
    CHECK(drive.unsteady(i, 0.1) == (holds[i] < 0 ? 0.0 : spread.unsteady(sample, 0.1)));
  }
  const Drive early(time, mean, {{InputDelay{0.9}, 0}}, 0, nullptr, {{0, {}}, {3, {}}});  // longer than the gap
  CHECK(early.switches().size() == 7);
}

TEST_CASE("Where a play stands is known about an input that is late, too, and of thinned ones", "[physics]") {
  RandomStream random(7);
  const FineInput fine = drawn(random);
  const std::vector<double> time{0.0, 0.1, 0.2, 1.0, 1.1, 1.2};
  const double departure = GENERATE(-0.4, 0.1), width = 0.5;
  for (const double delay : {0.0, 0.03}) {
    std::vector<Effect> effects{{Backlash{width}, 0}};
    if (delay > 0.0) effects.push_back({InputDelay{delay}, 0});
    const std::vector<double> input{4.0, 4.1, 4.0, -3.0, -3.1, -3.0};
    const Drive drive(time, input, effects, 0, nullptr,
                      {{0, JointVector{{departure}}}, {3, JointVector{{-departure}}}});
    const std::size_t first = delay > 0.0 ? 1 : 0, after = delay > 0.0 ? 5 : 3;
    CHECK(drive.at(first, delay) == Approx(4.0 + departure));
    CHECK(drive.at(after, 1.0 + delay) == Approx(-3.0 - departure));
  }
  const Drive thinned(time, std::vector<double>(6), {{Backlash{50.0}, 0}}, 0, &fine,
                      {{0, JointVector{{departure}}}, {3, JointVector{{-departure}}}});
  CHECK(thinned.at(0, 0.0) == Approx(fine.input(0, 0) + departure));  // it moves no more
  CHECK(thinned.at(5, 1.2) == Approx(fine.input(3 * kRowsEach, 0) - departure));
}
