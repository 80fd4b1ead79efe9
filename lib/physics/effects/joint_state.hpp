#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <numbers>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"
#include "physics/temperature.hpp"

namespace bayesctrl {

/// What an effect's formula may look at: one joint at one instant. SI units; for a slide read m, m/s, N.
struct JointState {
  double position = 0.0;
  double velocity = 0.0;
  double time = 0.0;             // since the start of the recording
  double motor_torque = 0.0;     // tau_in: what the input does to the joint, after the input effects
  double external_torque = 0.0;  // tau_ext: gravity and springs, along the joint
  double neighbour = 0.0;        // position of the joint that this one is coupled to
  double mobility = 0.0;         // 1/inertia of the joint, where an effect that swings against it is asked for its rate
  double temperature = kReferenceTemperature;
  double unsteady = 0.0;  // mean of |tau_in - tau_ext| less that of its mean, where the input changes meanwhile

  /// Mean of |tau_in - tau_ext|: on gears and bearings.
  double load() const { return std::abs(motor_torque - external_torque) + unsteady; }
};

/// The joint that one of several is coupled to: the next or, for the last, the one before.
inline int neighbour_of(int joint, int joints) { return joint + 1 < joints ? joint + 1 : joints > 1 ? joint - 1 : 0; }

/// 2 step, 3 step, ... below `highest`.
std::vector<double> multiples(double step, double highest);

/// The region that recordings visit in one joint: where the parameters of an effect can be looked for.
struct OperatingRange {
  double lowest = 0.0, highest = 0.0;                // position
  double speed = 0.0;                                // largest |velocity|
  double input = 0.0;                                // largest |u|
  double period = 0.01;                              // s between samples
  std::vector<double> durations;                     // s, of each recording
  int joints = 1;                                    // of the machine
  double coldest = kInfinity, warmest = -kInfinity;  // degrees Celsius, where that is recorded

  /// Of which one may differ from the others; 0: there is one.
  int recordings() const { return durations.size() > 1 ? static_cast<int>(durations.size()) : 0; }

  /// Frequencies (rad/s) that are worth trying between 2 `step` and `highest`: the multiples of `step`, or where these
  /// are too many the strongest in what is missing.
  std::function<std::vector<double>(double step, double highest)> frequencies = multiples;
};

/// A family of effects that is linear in coefficients: sum of coefficient * member. With `sign` 1 a coefficient cannot
/// be negative.
template <class E>
struct Shape {
  std::vector<E> members;
  int sign = 0;
  int recording = -1;                         // the only one in which it acts; -1: all
  double low = -kInfinity, high = kInfinity;  // bounds of every coefficient
};

/// The machine for which an effect is drawn.
struct DrawScales {
  double strength = 0.1;  // of the effect, from 0 (absent) on
  double torque = 1.0;    // that moves the joint,
  double input = 1.0;     // the largest that it is given,
  double range = 1.0;     // its positions,
  double speed = 3.0;     // and how fast it goes
  double duration = 1.0;  // s, of a recording
};

/// -1 or 1.
double drawn_sign(auto&& uniform) { return uniform(-1.0, 1.0) < 0.0 ? -1.0 : 1.0; }

/// Parameters that are angles, and those of which all admitted values are about as likely.
inline constexpr SearchInfo kAngle{.deviation = {2.0}, .step = {0.01}, .share = 0.0, .cycle = 2.0 * std::numbers::pi};
inline constexpr SearchInfo kAnyAdmitted{.deviation = {0.3, Measure::admitted}};

/// The hidden state of an effect.
template <std::size_t kCount>
using HiddenState = std::array<double, kCount>;

/// z after h seconds where z' is linear in z: `rate` now, and it settles at `settling_rate`.
inline double relaxed(double z, double rate, double settling_rate, double h) {
  const double decay = settling_rate * h;
  return z + rate * (decay < 1e-6 ? h : h * -std::expm1(-decay) / decay);
}

/// z moved along a rate for h seconds; the mean rate of a classical Runge-Kutta step.
template <std::size_t kCount>
HiddenState<kCount> moved(HiddenState<kCount> z, const HiddenState<kCount>& rate, double h) {
  for (std::size_t i = 0; i < kCount; ++i) z[i] += h * rate[i];
  return z;
}
template <std::size_t kCount>
HiddenState<kCount> mean_rate(const HiddenState<kCount>& a, const HiddenState<kCount>& b, const HiddenState<kCount>& c,
                              const HiddenState<kCount>& d) {
  HiddenState<kCount> mean;
  for (std::size_t i = 0; i < kCount; ++i) mean[i] = (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]) / 6.0;
  return mean;
}

/// `count` values from low to high in equal ratios; empty where there is no such interval.
std::vector<double> spread(double low, double high, int count);

}  // namespace bayesctrl
