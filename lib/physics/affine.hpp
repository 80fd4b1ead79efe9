#pragma once

#include "base/fields.hpp"
#include "base/vector.hpp"

namespace bayesctrl {

/// q'' = drift + gain u at one state (the paper's a(x) and b(x)): drift one per joint, gain joints x inputs. The number
/// of joints may be a constant.
template <int kJoints>
struct AffineOf {
  Joints<kJoints> drift;
  JointsSquare<kJoints> gain;

  operator AffineOf<Eigen::Dynamic>() const requires(kJoints != Eigen::Dynamic) { return {drift, gain}; }

  static AffineOf scalar(double a, double b) {
    return {Joints<kJoints>::Constant(1, a), JointsSquare<kJoints>::Constant(1, 1, b)};
  }
};
using Affine = AffineOf<Eigen::Dynamic>;

}  // namespace bayesctrl
