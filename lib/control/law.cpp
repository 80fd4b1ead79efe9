#include "control/law.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

JointVector feedback_linearise(const JointVector& drift, const JointMatrix& gain, const JointVector& acceleration) {
  JointVector u = acceleration - drift;
  if (u.size() == 1) {
    u[0] /= gain(0, 0);
  } else {
    u = JointSolver(gain).solve(u);
  }
  if (!u.allFinite()) throw NumericalError("the control input is not finite: the input gain cannot be inverted");
  return u;
}

JointVector linearise_cautiously(const BeliefMarginals& believed, const JointVector& acceleration, double caution) {
  if (caution > 0.0 && believed.gain_covariance.size() > 0) {
    const JointMatrix& b = believed.gain_mean;
    const JointMatrix curvature = b.transpose() * b + caution * believed.gain_covariance;
    const JointVector asked = b.transpose() * (acceleration - believed.drift_mean);
    const JointVector u = JointSolver(curvature).solve(JointVector(asked - caution * believed.drift_gain_covariance));
    if (u.allFinite()) return u;
  }
  return feedback_linearise(believed.drift_mean, believed.gain_mean, acceleration);
}

JointVector limited(const JointVector& u, const std::vector<double>& limit) {
  JointVector result = u;
  for (Eigen::Index i = 0; i < u.size() && !limit.empty(); ++i) {
    const double bound = limit.size() == 1 ? limit[0] : limit[i];
    result[i] = std::clamp(u[i], -bound, bound);
  }
  return result;
}

}  // namespace bayesctrl
