#pragma once

#include "base/fields.hpp"
#include "base/vector.hpp"

namespace bayesctrl {

/// q'' = drift + gain u at one state (the paper's a(x) and b(x)): drift one per joint, gain joints x inputs.
struct Affine {
  JointVector drift;
  JointMatrix gain;

  static Affine scalar(double a, double b) { return {JointVector::Constant(1, a), JointMatrix::Constant(1, 1, b)}; }
};

}  // namespace bayesctrl
