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

/// What a machine of one joint may be a draw from, the same samples under each. Apart: any of `drift` with any of
/// `log_gain`; together any one of both.
struct PossibleMachines {
  std::vector<Posterior> drift, log_gain;
};

/// The processes of a belief alone.
PossibleMachines as_believed(const Belief& belief);

/// By how much q'' is other than `used` expects, at most, at all rows of `states` (q, v) under these inputs at once,
/// with probability 1 - `risk` at least: the largest under any possible machine, of z sd(a + E' log b) + what is curved
/// in exp(log b) + what their means differ, by a union bound over the states. Infinite where b is believed to be
/// without bound. What exceeds `limit` is not looked at further.
double acceleration_bound(const Belief& used, const PossibleMachines& possible, const Eigen::MatrixXd& states,
                          const Eigen::ArrayXd& inputs, double risk, double limit = kInfinity);

/// The error of a loop that begins at its goal at rest. Where |q'' - u'| is at most `disturbance`(r) at all states with
/// |e| <= r and |e'| <= r velocity / position, the loop never leaves them if that times `position` is at most r, and
/// its error never exceeds the former: the least of these over a series of `radii`; NaN if there is none.
double contained_error(const DisturbanceGain& gain, const std::vector<double>& radii,
                       const std::function<double(double)>& disturbance);

/// A bound on the error with which `linearise_cautiously` with `used` holds a machine of one joint at `goal`, beginning
/// there at rest, by `contained_error`. The disturbance is the largest, with probability 1 - `risk` at least, and what
/// E q'' misses of u', at 7 x 7 states for each radius, which lie no further apart than 0.4 of the shortest length
/// scale; between them it is taken to be no larger. Control is taken to be continuous, and the state to be seen as it
/// is. NaN if there is no bound within the box (of q and v), or within the limits of the input.
double error_bound(const InnerLaw& law, double caution, const std::vector<double>& input_limit, double goal,
                   const Box& box, const Belief& used, const PossibleMachines& possible, double risk);

}  // namespace bayesctrl
