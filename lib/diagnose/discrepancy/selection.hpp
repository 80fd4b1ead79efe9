#pragma once

#include "diagnose/discrepancy/discrepancy.hpp"

namespace bayesctrl {

/// What stands in for physics that no catalogue has: a model with a remainder that predicts recordings best.
struct SelectedDiscrepancy {
  Fit fit;                            // nominal, or with the effects of the best explanation
  Remainder remainder;                // beside it; may be empty
  Discrepancy::Dependence remaining;  // what that which `fit` leaves depends on
  Discrepancy::Dependence whole;      // and what the nominal leaves
};

/// Of the nominal and the best explanation, each with and without a remainder, what predicts blocks of the training
/// recordings best that were left out when it was learnt. `discrepancy` is about `explanation.measured`, `about_best`
/// about `explanation.linearisation`; `target`: rows of the former that are to be explained; `motion`: smoothed
/// recordings.
SelectedDiscrepancy select_discrepancy(const Explanation& explanation, const Discrepancy& discrepancy,
                                       const Discrepancy& about_best, const Eigen::VectorXd& target,
                                       const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
                                       double horizon);

/// The same beside the best explanation alone: its remainder, empty where it predicts nothing.
SelectedDiscrepancy select_beside_best(const Explanation& explanation, const Discrepancy& about_best,
                                       const std::vector<Measured>& data, const std::vector<Trajectory>& motion,
                                       double horizon);

}  // namespace bayesctrl
