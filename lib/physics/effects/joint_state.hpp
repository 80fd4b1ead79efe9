#pragma once

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "base/fields.hpp"

namespace bayesctrl {

/// What an effect's formula may look at: one joint at one instant. SI units; for a slide read m, m/s, N.
struct JointState {
  double position = 0.0;
  double velocity = 0.0;
  double time = 0.0;             // since the start of the recording
  double motor_torque = 0.0;     // tau_in: what the input does to the joint, after the input effects
  double external_torque = 0.0;  // tau_ext: gravity and springs, along the joint
  double neighbour = 0.0;        // position of the joint that this one is coupled to
};

/// The joint that one of several is coupled to: the next or, for the last, the one before.
inline int neighbour_of(int joint, int joints) { return joint + 1 < joints ? joint + 1 : joints > 1 ? joint - 1 : 0; }

/// The region that recordings visit in one joint: where the parameters of an effect can be looked for.
struct Survey {
  double lowest = 0.0, highest = 0.0;  // position
  double speed = 0.0;                  // largest |velocity|
  double input = 0.0;                  // largest |u|
  double period = 0.01;                // s between samples
  std::vector<double> durations;       // s, of each recording
  int joints = 1;                      // of the machine
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

/// `count` values from low to high in equal ratios; empty where there is no such interval.
std::vector<double> spread(double low, double high, int count);

}  // namespace bayesctrl
