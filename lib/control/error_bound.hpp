#pragma once

#include <Eigen/Core>
#include <functional>
#include <vector>

#include "control/belief.hpp"
#include "control/law.hpp"
#include "gp/bound.hpp"

namespace bayesctrl {

/// How far a disturbance of the acceleration that never exceeds 1 drives the double integrator under the inner law:
/// e'' + w2 e' + w1 e = d from e = e' = 0 has |e| <= position and |e'| <= velocity, and no smaller numbers do (the
/// integrals of |h| and |h'|, h the response to an impulse).
struct DisturbanceGain {
  double position = 0.0, velocity = 0.0;
};
DisturbanceGain disturbance_gain(const InnerLaw& law);

/// By how much q'' of a machine of one joint is other than `used` expects, at all rows of `states` (q, v) under these
/// inputs at once, with probability 1 - `risk` at least if the machine is a draw from one of the `possible` beliefs:
/// the largest under any of them, of z sd(a + E' log b) + what is curved in exp(log b) + what their means differ, by a
/// union bound over the states.
Eigen::ArrayXd acceleration_bounds(const Belief& used, const std::vector<Belief>& possible,
                                   const Eigen::MatrixXd& states, const Eigen::ArrayXd& inputs, double risk);

/// The error of a loop that begins at its goal at rest. Where |q'' - u'| is at most `disturbance`(r) at all states with
/// |e| <= r and |e'| <= r velocity / position, the loop never leaves them if that times `position` is at most r, and
/// its error never exceeds the former: the least of these over a series of `radii`; NaN if there is none.
double contained_error(const DisturbanceGain& gain, const std::vector<double>& radii,
                       const std::function<double(double)>& disturbance);

/// A bound on the error with which feedback linearisation with `used` holds a machine of one joint at `goal`, beginning
/// there at rest, that holds with probability 1 - `risk` at least if the machine is a draw from `used` or one of the
/// `others`; NaN if there is none within the box (of q and v), or within the limits of the input. By `contained_error`;
/// the disturbance is that of 7 x 7 states for each radius, and control is taken to be continuous.
double error_bound(const InnerLaw& law, const std::vector<double>& input_limit, double goal, const Box& box,
                   const Belief& used, const std::vector<Belief>& others, double risk);

}  // namespace bayesctrl
