#include "control/window_sampler.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

constexpr double kBetweenCalls = 0.01;  // s
constexpr double kTrueDrift = -1.5, kTrueGain = 2.0;

StateVector state_at(double t, double u) {
  const double a = kTrueDrift + kTrueGain * u;
  return Eigen::Vector2d(0.3 + 0.8 * t + 0.5 * a * t * t, 0.8 + a * t);
}

/// q'' = kTrueDrift + kTrueGain u under a constant input, seen with noise.
History constant_motion(int calls, double u, double noise, RandomStream& random) {
  History history(1, calls);
  for (int k = 0; k < calls; ++k) {
    StateVector seen = state_at(k * kBetweenCalls, u);
    for (double& value : seen) value += noise * draw_normal(random);
    history.add(seen);
    history.hold(JointVector::Constant(1, u));
  }
  return history;
}

const Timings kAtOnce{{}};
const JointMatrix kBelieved = JointMatrix::Constant(1, 1, kTrueGain);

}  // namespace

TEST_CASE("A constant acceleration is measured in the middle of any window, and carried on to its end", "[control]") {
  RandomStream random(5);
  for (const bool positions_only : {true, false}) {
    const WindowSampler sampler({}, true, 1, kBetweenCalls, positions_only);
    const History history = constant_motion(80, 1.2, 0.0, random);
    for (int samples = sampler.shortest(); samples <= sampler.longest(); ++samples) {
      const long first = 20;
      const WindowSample sample = sampler(history, first, samples, kAtOnce, kBelieved);
      const double end = (first + samples - 1) * kBetweenCalls, middle = end - 0.5 * (samples - 1) * kBetweenCalls;
      CHECK((sample.derivative.x - state_at(middle, 1.2)).norm() < 1e-9);
      CHECK(sample.derivative.acceleration[0] == Approx(kTrueDrift + kTrueGain * 1.2));
      CHECK(sample.derivative.input[0] == Approx(1.2));
      CHECK((sample.end - state_at(end, 1.2)).norm() < 1e-9);
    }
  }
}

TEST_CASE("A jump of the input within a window does not move the state at its end", "[control]") {
  const long jump = 30;
  const double at_jump = jump * kBetweenCalls;
  const StateVector then = state_at(at_jump, 0.0);
  for (const bool positions_only : {true, false}) {
    const WindowSampler sampler({}, true, 1, kBetweenCalls, positions_only);
    History history(1, 80);
    for (long k = 0; k < 80; ++k) {
      const double t = static_cast<double>(k) * kBetweenCalls, since = t - at_jump, a = kTrueDrift + kTrueGain * 2.5;
      history.add(k < jump ? state_at(t, 0.0)
                           : StateVector(Eigen::Vector2d(then[0] + since * then[1] + 0.5 * a * since * since,
                                                         then[1] + a * since)));
      history.hold(JointVector::Constant(1, k < jump ? 0.0 : 2.5));
    }
    for (int samples = sampler.shortest(); samples <= sampler.longest_probe(); ++samples) {
      for (long first = jump - samples; first <= jump; ++first) {
        const WindowSample sample = sampler(history, first, samples, kAtOnce, kBelieved);
        CHECK((sample.end - history.seen(first + samples - 1)).norm() < 1e-9);
      }
    }
  }
}

TEST_CASE("Windows become as long as the noise that they have seen makes necessary", "[control]") {
  RandomStream random(6);
  const DerivativeWindow spec;
  for (const double noise : {0.0, 1e-6, 1e-5, 1e-4, 1e-3}) {
    WindowSampler sampler(spec, true, 1, kBetweenCalls, true);
    CHECK(sampler.samples() == sampler.shortest());
    const History history = constant_motion(1000, 0.0, noise, random);
    for (long first = 0; first < 980; first += 20) sampler.keep(sampler(history, first, 20, kAtOnce, kBelieved));
    CHECK(std::sqrt(sampler.noise(JointVector::Zero(1), 0.0)[0]) == Approx(noise).epsilon(0.35).margin(1e-12));
    CHECK(std::sqrt(sampler.difference_variance()[0]) ==
          Approx(std::sqrt(2.0) * noise / kBetweenCalls).epsilon(0.35).margin(1e-9));
    CHECK(sampler.longest_probe() == std::lround(spec.longest / kBetweenCalls) + 1);
    const double sd = std::sqrt(sampler.acceleration_variance()[0]);
    if (noise < 1e-3) CHECK(sd <= spec.accuracy);
    CHECK(sampler.samples_for(1e-12, sampler.longest()) == (noise < 1e-6 ? sampler.shortest() : sampler.longest()));

    // That standard deviation is what windows of this length have.
    double squares = 0.0;
    int count = 0;
    for (long first = 0; first + sampler.samples() <= 1000; first += sampler.samples(), ++count) {
      const WindowSample sample = sampler(history, first, sampler.samples(), kAtOnce, kBelieved);
      squares += std::pow(sample.derivative.acceleration[0] - kTrueDrift, 2);
    }
    CHECK(std::sqrt(squares / count) == Approx(sd).epsilon(0.3).margin(1e-6));
  }
}
