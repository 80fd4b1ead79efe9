#pragma once

#include <functional>

#include "diagnose/motion/smoother.hpp"
#include "physics/machine/machine.hpp"

namespace bayesctrl {

/// State at the first sample of a window: [q, v] and, where any of them is not known, the hidden states of effects,
/// lags, and plays (from the middle of their gap).
using SegmentState = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 4 * kMaxJoints + kMaxHidden, 1>;

/// Step of differences by an initial state.
inline constexpr double kSegmentStateStep = 1e-5;

/// An initial state and what is left of its segment, samples x joints.
struct SegmentRun {
  SegmentState start;
  Eigen::MatrixXd residual;
};

/// Levenberg-Marquardt: the initial state that makes `residual` (samples x joints) smallest, from `start`. One whose
/// simulation diverges throws NumericalError. `precision`: 1 / variance a priori of each component, about 0; `reach`:
/// of each component to either side of 0, from whose ends it begins as well; none: as far as it likes.
SegmentRun fit_initial_state(const std::function<Eigen::MatrixXd(const SegmentState&)>& residual,
                             const SegmentState& start, int rounds, const SegmentState& precision,
                             const SegmentState& reach = {});

/// Along which differences by one component are made: towards 0 where it has come to the end of its reach.
double state_step(const SegmentState& start, Eigen::Index component, const SegmentState& reach);

/// A first guess from a known motion, as the sensors show it. Effects' states, lags and plays are not known at a first
/// sample, of a recording or after a gap.
SegmentState initial_guess(const Segment& window, const Trajectory& path, const Machine& machine);

/// Copies the initial state that another model has found into that of a model with so many joints, as far as both hold
/// the same components.
void hand_down(const SegmentState& found, int joint_count, SegmentState& start);

/// The hidden states of an initial state, where it has them; else what is known of them.
HiddenStates hidden_states_of(const SegmentState& start, HiddenStates known);

/// Where plays stand in an initial state, of a first sample; none where it does not say.
JointVector plays_of(const SegmentState& start, int joint_count);

/// 1 / variance a priori of its components: lags and plays are within the range of the input, all else may be anything.
SegmentState precision_of(const SegmentState& start, const Measured& data);

/// Reach of its components: plays within their gaps, all else without end; none where it does not say where plays
/// stand.
SegmentState reach_of(const SegmentState& start, const Machine& machine);

/// Its components within their reach.
SegmentState within(SegmentState start, const SegmentState& reach);

/// The precision as weights of the residuals of one window, which measure its noise (residual: samples x joints).
SegmentState weights_of(const SegmentState& precision, const Eigen::MatrixXd& residual);

/// Machines of a plant with effects, one per recording.
std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, const std::vector<Measured>& data,
                              const Remainder& remainder = {});

/// The input of each joint as a machine feels it during one recording. `plays`: where it is known how they stand.
/// `samples`: of its beginning alone; 0: all.
std::vector<Drive> drives_of(const Machine& machine, const Measured& data, const Restarts& plays = {},
                             std::size_t samples = 0);

/// Those of a window whose initial state says where plays stand; none: the recording's hold.
std::vector<Drive> own_drives(const Machine& machine, const Measured& data, const Segment& window,
                              const SegmentState& start);

}  // namespace bayesctrl
