#pragma once

#include <functional>

#include "diagnose/motion/smoother.hpp"
#include "physics/machine/machine.hpp"

namespace bayesctrl {

/// State at the first sample of a window: [q, v] and, where they are not known, the hidden states of effects and lags.
using WindowStart = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3 * kMaxJoints + kMaxHidden, 1>;

/// Step of differences by a start.
inline constexpr double kStartStep = 1e-5;

/// Levenberg-Marquardt: the start from `start` on that makes `rest` (samples x joints) smallest. One whose simulation
/// diverges throws NumericalError. `precision`: 1 / variance a priori of each component, about 0.
WindowStart fit_start(const std::function<Eigen::MatrixXd(const WindowStart&)>& rest, WindowStart start, int rounds,
                      const WindowStart& precision);

/// A first guess from a known motion. Effects' states are not known after a gap, a lag nowhere before the first sample.
WindowStart first_start(const Segment& window, const Trajectory& path, const Machine& machine);

/// Puts a start that another model has found into the start of a model with so many joints, as far as both know the
/// same.
void hand_down(const WindowStart& found, int joint_count, WindowStart& start);

/// The hidden states of a start, where it has them; else what is known of them.
HiddenStates hidden_states_of(const WindowStart& start, const Segment& window, HiddenStates known);

/// 1 / variance a priori of a start's components: lags are within the range of the input, all else may be anything.
WindowStart precision_of(const WindowStart& start, const Measured& data);

/// The same as weights of the residuals of one window, which measure its noise (rest: samples x joints).
WindowStart weights_of(const WindowStart& precision, const Eigen::MatrixXd& rest);

/// Machines of a plant with effects, one per recording.
std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings);

/// The input of each joint as a machine feels it during one recording.
std::vector<Drive> drives_of(const Machine& machine, const Measured& data);

}  // namespace bayesctrl
