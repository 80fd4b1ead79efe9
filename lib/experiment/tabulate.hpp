#pragma once

#include "experiment/run.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// One row per controller: experiment, the swept settings, controller, status, reason, then every metric.
Table summary_table(const StudyOutcome& outcome);

/// One row per control call: t, state, input, mode ("control", "learn_a", "learn_b1", ...), reference and, for an
/// adaptive controller, mean and variance of each a_i and b_ij and of log b_ii. One joint's columns carry no number.
Table trajectory_table(const LoopResult& result);

/// The training points: process ("a", "log_b", or "b12" beside the diagonal; numbered for several joints), input x,
/// target, noise variance.
Table data_table(const Belief& belief);

/// The belief on the study's grid: |a - E a| (the paper's figures), standard deviation of a, mean and standard
/// deviation of log b, and the true log b, for each joint; with a confidence, bounds that hold all over the grid's box,
/// hyper-parameters that `controller` tunes being drawn from their posterior. Empty if the study asks for no points.
Table posterior_table(const Study& study, const Belief& belief, const std::string& controller = "");

}  // namespace bayesctrl
