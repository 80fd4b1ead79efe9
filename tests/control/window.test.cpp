#include "control/window.hpp"

#include <catch2/catch.hpp>
#include <cmath>

#include "base/random.hpp"

using namespace bayesctrl;

namespace {

constexpr double kSampling = 0.01;  // s

/// q'' = -2 sin(1.7 t) + 3 w(t), where w is the input of `u_at` after a delay and a lag, from q = 0.4 and v = -0.7, by
/// steps of a hundredth of a control period; seen with noise.
History motion(int calls, const Timing& timing, auto&& u_at, double noise = 0.0) {
  constexpr int kPieces = 100;
  const double h = kSampling / kPieces;
  RandomStream random(3);
  History history(1, calls);
  double q = 0.4, v = -0.7, w = 0.0;
  for (int k = 0; k < calls; ++k) {
    history.add(Eigen::Vector2d(q + noise * draw_normal(random), v + noise * draw_normal(random)));
    history.hold(JointVector::Constant(1, u_at(k)));
    for (int i = 0; i < kPieces; ++i) {
      const double t = k * kSampling + (i + 0.5) * h, late = t - timing.delay;
      const double u = late < 0.0 ? 0.0 : u_at(static_cast<int>(std::floor(late / kSampling + 1e-9)));
      const double before = w;
      w = timing.lag > 0.0 ? u + (w - u) * std::exp(-h / timing.lag) : u;
      const double a = -2.0 * std::sin(1.7 * t) + 1.5 * (before + w);
      q += h * (v + 0.5 * h * a);
      v += h * a;
    }
  }
  return history;
}

double probe_at_30(int k) { return k < 30 ? 1.0 : 4.0; }

}  // namespace

TEST_CASE("A window is exact for motions whose acceleration changes linearly", "[control]") {
  for (const bool positions_only : {true, false}) {
    for (const int samples : {5, 6, 12, 21}) {
      const WindowFit fit(samples, kSampling, positions_only);
      Eigen::VectorXd q(samples), v(samples);
      for (int k = 0; k < samples; ++k) {
        const double s = (k - 0.5 * (samples - 1)) * kSampling;
        q[k] = 0.3 - 0.8 * s + 2.0 * s * s / 2.0 - 5.0 * s * s * s / 6.0;
        v[k] = -0.8 + 2.0 * s - 5.0 * s * s / 2.0;
      }
      const WindowFit::Result result = fit(q, v);
      CHECK(result.position == Approx(0.3));
      CHECK(result.velocity == Approx(-0.8));
      CHECK(result.acceleration == Approx(2.0));
      CHECK(result.rest < 1e-20);
    }
  }
}

TEST_CASE("The variance of a window's acceleration is that of many windows with noise", "[control]") {
  RandomStream random(11);
  for (const bool positions_only : {true, false}) {
    const WindowFit fit(11, kSampling, positions_only);
    double squares = 0.0, rest = 0.0;
    const int windows = 4000;
    for (int w = 0; w < windows; ++w) {
      Eigen::VectorXd q(11), v(11);
      for (double& value : q) value = 1e-3 * draw_normal(random);
      for (double& value : v) value = 1e-3 * draw_normal(random);
      const WindowFit::Result result = fit(q, v);
      squares += result.acceleration * result.acceleration;
      rest += result.rest / fit.degrees_of_freedom();
    }
    CHECK(squares / windows == Approx(1e-6 * fit.acceleration_variance()).epsilon(0.08));
    CHECK(rest / windows == Approx(1e-6).epsilon(0.05));
  }
}

TEST_CASE("The motion that an input makes is the difference that it makes, with any delay and lag", "[control]") {
  const auto none = [](int) { return 0.0; };
  for (const Timing& timing :
       {Timing{}, Timing{0.01, 0.0}, Timing{0.0125, 0.0}, Timing{0.0, 0.02}, Timing{0.0075, 0.015}}) {
    const auto wave = [](int k) { return std::sin(0.4 * k); };
    const History with = motion(60, timing, wave), without = motion(60, timing, none);
    const InputMotion acting = motion_of_input(with, 0, 0, 60, kSampling, timing);
    INFO("delay " << timing.delay << ", lag " << timing.lag);
    for (const int k : {10, 30, 59}) {
      CHECK(3.0 * acting.twice[k] == Approx(with.seen(k)[0] - without.seen(k)[0]).margin(2e-4));
      CHECK(3.0 * acting.once[k] == Approx(with.seen(k)[1] - without.seen(k)[1]).margin(2e-3));
    }
  }
}

TEST_CASE("The jump at a probe's beginning tells b, whatever the drift is", "[control]") {
  for (const bool positions_only : {true, false}) {
    for (const Timing& timing : {Timing{}, Timing{0.02, 0.0}, Timing{0.0, 0.02}}) {
      const History history = motion(60, timing, probe_at_30);
      const JumpFit fit = fit_jump(history, 0, 22, 42, kSampling, positions_only, {timing}, JointMatrix::Zero(1, 1));
      INFO("positions only " << positions_only << ", delay " << timing.delay << ", lag " << timing.lag);
      CHECK(fit.gain[0] == Approx(3.0).epsilon(0.02));
      CHECK(std::abs(fit.gain[0] - 3.0) <= 3.0 * std::abs(fit.bias[0]) + 1e-2);
    }
  }
  const History still = motion(60, {}, [](int) { return 1.0; });
  const JumpFit none = fit_jump(still, 0, 22, 42, kSampling, false, {Timing{}}, JointMatrix::Zero(1, 1));
  CHECK(none.degrees_of_freedom == 0);  // an input that does not change tells nothing
}

TEST_CASE("Probes tell how late an input acts, and do not claim to know where noise hides it", "[control]") {
  for (const Timing& timing : {Timing{}, Timing{0.01, 0.0}, Timing{0.0225, 0.0}, Timing{0.0, 0.02}}) {
    const History history = motion(60, timing, probe_at_30);
    for (const bool positions_only : {true, false}) {
      TimingEstimate estimate(1, 0.05, kSampling, positions_only);
      CHECK_FALSE(estimate.known());
      estimate.add(history, 22, 48);
      INFO("positions only " << positions_only << ", delay " << timing.delay << ", lag " << timing.lag);
      CHECK(estimate.known());
      CHECK(latest(estimate.best()).together() == Approx(timing.together()).margin(0.003));
    }
  }
  TimingEstimate blind(1, 0.05, kSampling, true);
  blind.add(motion(60, {}, probe_at_30, 0.05), 22, 48);
  CHECK_FALSE(blind.known());
  TimingEstimate fine(1, 1.0, 1e-3, true);  // a thousand periods: asked in coarser steps, within a moment
  fine.add(motion(60, {}, probe_at_30), 22, 48);
  CHECK(TimingEstimate(1, 0.0, kSampling, true).known());  // there is nothing to find out
  CHECK(TimingEstimate(Timings{{0.02, 0.0}}).known());
}

TEST_CASE("Each input is told its own delay and lag, by probes in which it alone changes", "[control]") {
  const Timing first{0.02, 0.0}, second{0.0, 0.03};
  const auto probe_at_80 = [](int k) { return k < 80 ? 1.0 : -2.0; };
  const History one = motion(120, first, probe_at_30), two = motion(120, second, probe_at_80);
  History both(2, 120);
  for (int k = 0; k < 120; ++k) {
    both.add(Eigen::Vector4d(one.seen(k)[0], two.seen(k)[0], one.seen(k)[1], two.seen(k)[1]));
    both.hold(Eigen::Vector2d(probe_at_30(k), probe_at_80(k)));
  }
  for (const bool positions_only : {true, false}) {
    TimingEstimate estimate(2, 0.05, kSampling, positions_only);
    CHECK_FALSE(estimate.add(both, 22, 98));  // both change: nothing is told
    CHECK(latest(estimate.best()) == Timing{});
    CHECK(estimate.add(both, 22, 48));
    CHECK(estimate.known(0));
    CHECK_FALSE(estimate.known());  // the second
    estimate.add(both, 72, 98);
    CHECK(estimate.known());
    CHECK(estimate.best()[0].together() == Approx(0.02).margin(0.003));
    CHECK(estimate.best()[1].together() == Approx(0.03).margin(0.005));
    CHECK(estimate.best()[1].lag > estimate.best()[1].delay);
    CHECK(latest(estimate.best()) == estimate.best()[1]);
  }
}

TEST_CASE("The history keeps the last calls, and inputs before the first are 0", "[control]") {
  History history(1, 4);
  for (int k = 0; k < 6; ++k) {
    history.add(Eigen::Vector2d(k, -k));
    history.hold(JointVector::Constant(1, 10.0 * k));
  }
  CHECK(history.seen(5)[0] == 5.0);
  CHECK(history.input(5)[0] == 50.0);
  CHECK(history.input(0)[0] == 20.0);  // the oldest that is kept
  CHECK(history.input(-1)[0] == 0.0);
}
