#pragma once

#include <memory>

#include "physics/machine/machine.hpp"

namespace bayesctrl {

/// A machine in a closed loop: the input of each moment is settled while it moves.
class Simulation {
 public:
  /// `machine` must outlive the simulation. Lags have settled on that `part` of the first input.
  Simulation(const Machine& machine, const StateVector& start, double time, double max_step = 0.005, double part = 1.0);
  ~Simulation();

  /// The input is held from the present time on, once for each time.
  void hold(const JointVector& input);

  /// Throws NumericalError where the machine diverges.
  void advance(double time);

  StateVector state() const;  // true [q, v]

 private:
  struct Now;
  const Machine& machine_;
  double max_step_;
  double part_;
  std::unique_ptr<Now> now_;
};

}  // namespace bayesctrl
