#pragma once

#include <optional>
#include <vector>

#include "base/fields.hpp"
#include "base/vector.hpp"
#include "control/belief.hpp"
#include "control/reference.hpp"

namespace bayesctrl {

/// The inner-loop law u'(x) = xi'' + w1 (xi1 - x1) + w2 (xi2 - x2) (the paper's Eq. for u' with a feed-forward of the
/// reference's acceleration, zero for a set-point), a desired acceleration.
struct InnerLaw {
  double position_weight = 1.0;
  double velocity_weight = 1.0;
  double lead = 0.0;

  static void fields(auto& self, auto&& field) {
    field("position_weight", self.position_weight, {kPositive, "1/s^2", "w1", kRequired});
    field("velocity_weight", self.velocity_weight, {kPositive, "1/s", "w2", kRequired});
    field(
        "lead", self.lead,
        {kNonNegative, "s",
         "a and b are taken at the velocity that u' leads to in this time: dry friction then opposes what is wanted"});
  }

  JointVector operator()(const ReferencePoint& xi, const JointVector& q, const JointVector& v) const {
    return xi.acceleration + position_weight * (xi.position - q) + velocity_weight * (xi.velocity - v);
  }
  bool operator==(const InnerLaw&) const = default;
};

/// Feedback linearisation u = b^-1 (-a + u') (the paper's control law with posterior means for a and b). Throws
/// NumericalError if b cannot be inverted or the result is not finite.
JointVector feedback_linearise(const JointVector& drift, const JointMatrix& gain, const JointVector& acceleration);

/// The input that minimises |E q'' - u'|^2 + caution * sum_i var q_i'', of a belief whose processes are together:
/// cautious control (Astrom & Wittenmark 1995, Ch. 7). Where b is vague, its mean nearly singular, it does not ask for
/// what only that mean promises; what learning in passing has shown of a + b u at the inputs of before draws it there.
/// Without caution, covariances, or a finite result, feedback linearisation by the means. Throws as that does.
JointVector linearise_cautiously(const BeliefMarginals& believed, const JointVector& acceleration, double caution);

/// Each input within +-limit; an empty list means no limits, a list of one serves every input.
JointVector limited(const JointVector& u, const std::vector<double>& limit);

}  // namespace bayesctrl
