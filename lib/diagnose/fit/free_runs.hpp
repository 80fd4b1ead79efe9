#pragma once

#include <functional>

#include "diagnose/fit/fit.hpp"
#include "physics/discrepancy/remainder.hpp"

namespace bayesctrl {

/// A corrected machine: what simulations are made of.
struct Corrected {
  Plant plant;
  std::vector<Effect> effects;
  Remainder remainder;
};

/// What a remainder remembers at the sample `to` of a known motion, from what it remembers at `from`; with nothing it
/// begins at the first sample.
Remainder::Memory remember(const Remainder& remainder, const Measured& data, const Trajectory& path, std::size_t from,
                           std::size_t to, Remainder::Memory memory);

/// Free runs over windows laid back to back, the initial state of each fitted to it by least squares.
struct FreeRuns {
  double rms = 0.0;                        // measured less simulated position, all samples and joints
  double samples = 0.0;                    // that it is the mean of
  Eigen::VectorXd joint_rms;               // the same of each joint
  std::vector<double> window_rms;          // the same of each window
  std::vector<Eigen::MatrixXd> simulated;  // measured positions as simulated, per recording; NaN outside of windows
  std::vector<Eigen::MatrixXd> velocity;   // of the same runs
};

/// Windows of `horizon` seconds. `paths` give the first guess of initial states, and what came before a window to
/// states that remember. A window whose simulation diverges counts with its measured motion about its mean. With
/// `new_recordings` effects of one recording act in all: what has changed is expected to stay. Only windows that are
/// `wanted`, if that is given.
FreeRuns free_runs(const Corrected& model, const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
                   double horizon, bool new_recordings, double max_step,
                   const std::function<bool(const Segment&)>& wanted = {});

}  // namespace bayesctrl
