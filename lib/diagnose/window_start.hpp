#pragma once

#include <functional>

#include "diagnose/smoother.hpp"
#include "physics/machine.hpp"

namespace bayesctrl {

/// State at the first sample of a window: [q, v] and, after a gap, the states of the joints' effects (presliding).
using WindowStart = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, 3 * kMaxJoints, 1>;

/// Step of differences by a start.
inline constexpr double kStartStep = 1e-5;

/// Levenberg-Marquardt: the start from `start` on that makes `rest` (samples x joints) smallest. One whose simulation
/// diverges throws NumericalError.
WindowStart fit_start(const std::function<Eigen::MatrixXd(const WindowStart&)>& rest, WindowStart start, int rounds);

/// A first guess from a known motion. With `hidden` effects have states of their own.
WindowStart first_start(const Segment& window, const Trajectory& path, bool hidden);

/// Machines of a plant with effects, one per recording.
std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings);

/// The input of each joint as a machine feels it during one recording.
std::vector<Drive> drives_of(const Machine& machine, const Measured& data);

}  // namespace bayesctrl
