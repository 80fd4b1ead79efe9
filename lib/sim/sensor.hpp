#pragma once

#include <cmath>
#include <vector>

#include "base/fields.hpp"
#include "base/random.hpp"
#include "base/vector.hpp"

namespace bayesctrl {

/// What the controller sees at each call: the exact state by default, or positions only with the flaws of an encoder.
struct Sensor {
  bool positions_only = false;
  double noise = 0.0;
  double velocity_noise = 0.0;
  double quantum = 0.0;
  int delay_periods = 0;

  static void fields(auto& self, auto&& field) {
    field("positions_only", self.positions_only, {.text = "velocities are estimated from the last three positions"});
    field("noise", self.noise, {kNonNegative, "rad or m", "standard deviation of the position's white noise"});
    field("velocity_noise", self.velocity_noise, {kNonNegative, "rad/s or m/s", "the same for measured velocities"});
    field("quantum", self.quantum,
          {kNonNegative, "rad or m", "positions are rounded to multiples of this; 0: not rounded"});
    field("delay_periods", self.delay_periods,
          {between(0, 1000), "control periods", "age of a measurement when it is seen"});
  }
  bool operator==(const Sensor&) const = default;
};

/// Measured positions and velocities of one run. Its noise follows from the stream that it is given.
class Measurement {
 public:
  /// `samples` is the number of control calls to come; nothing is allocated afterwards.
  Measurement(const Sensor& sensor, double dt, int joints, std::size_t samples, RandomStream random);

  /// Takes the true state at the next control call and returns what the controller sees of it, [q, v].
  StateVector operator()(const StateVector& truth);

 private:
  StateVector measure(const StateVector& truth);

  Sensor sensor_;
  double dt_;
  std::vector<StateVector> truth_;     // only kept under a delay
  std::vector<StateVector> measured_;  // the last three
  std::size_t calls_ = 0;
  RandomStream random_;
};

}  // namespace bayesctrl
