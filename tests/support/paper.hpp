#pragma once

#include "sim/loop.hpp"

namespace bayesctrl::testing {

/// Experiment 1, 2 or 3 with the settings of the paper's Table 1: pendulum (l, r, m), Delta_u, Delta_lambda,
/// thresholds, x0 = (0, -2), xi = (pi, 0), weights and t_f. The belief is left empty.
LoopSetup paper_experiment(int number, Controller controller);

/// A set-up for any plant: moderate start, set-point, 0.01 s control period, belief as `example_belief`.
LoopSetup example_setup(const Plant& plant, const Controller& controller, double duration);

/// Squared exponential processes for a, log b and the couplings; unit output scales, length scales 2.
BeliefPrior example_prior(int joints);

/// `example_prior` with `samples` samples of a smooth function in each process, at random states.
Belief example_belief(int joints, int samples);

/// Thresholds that no process of the tests exceeds: the run never probes.
Learner never_learning();

/// Whether two runs recorded the same times, states, inputs and modes, bit for bit.
bool same_steps(const LoopResult& one, const LoopResult& other);

}  // namespace bayesctrl::testing
