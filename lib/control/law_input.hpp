#pragma once

#include "control/belief.hpp"
#include "physics/affine.hpp"

namespace bayesctrl {

/// What a control law may look at beside the state.
enum class Knowledge { nothing, truth, belief };

/// What a control law is given: the inner law's acceleration, and what it may know of the plant at this state.
struct LawInput {
  const JointVector& acceleration;          // u'(x) of the inner law
  const Affine* truth = nullptr;            // for Knowledge::truth
  const BeliefMarginals* belief = nullptr;  // for Knowledge::belief
};

}  // namespace bayesctrl
