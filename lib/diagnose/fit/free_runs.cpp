#include "diagnose/fit/free_runs.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

Remainder::Memory remember(const Remainder& remainder, const Measured& data, const Trajectory& path, std::size_t from,
                           std::size_t to, Remainder::Memory memory) {
  if (memory.empty()) {
    memory = remainder.begin(path.position.row(0), path.velocity.row(0));
  }
  for (std::size_t k = from; k < to; ++k) {
    const auto row = static_cast<Eigen::Index>(k);
    remainder.advance(memory, 0.5 * (path.position.row(row) + path.position.row(row + 1)),
                      0.5 * (path.velocity.row(row) + path.velocity.row(row + 1)), input_at(data, k, 0.5),
                      data.time[k + 1] - data.time[k]);
  }
  return memory;
}

FreeRuns free_runs(const Corrected& model, const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
                   double horizon, bool new_recordings, double max_step,
                   const std::function<bool(const Segment&)>& wanted) {
  if (!model.remainder.empty()) max_step = std::min(max_step, kSettings.fit.remainder_step);
  FreeRuns result;
  const int n = joints(model.plant);
  std::vector<Effect> effects = model.effects;
  if (new_recordings) effects = in_new_recordings(std::move(effects));
  const std::vector<Machine> list = machines(model.plant, effects, data, model.remainder);
  std::vector<std::vector<Drive>> drives;
  std::vector<Restarts> plays(data.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    drives.push_back(drives_of(list[r], data[r]));
    result.simulated.push_back(Eigen::MatrixXd::Constant(data[r].position.rows(), n, std::nan("")));
    result.velocity.push_back(result.simulated.back());
  }
  double squares = 0.0;
  Eigen::VectorXd joint_squares = Eigen::VectorXd::Zero(n);
  HiddenStates hidden;  // as the window before has found them,
  Remainder::Memory memory;
  std::size_t of = data.size(), reached = 0;  // at this sample of this recording
  for (const Segment& window : windows(data, horizon)) {
    if (wanted && !wanted(window)) continue;
    const std::size_t r = window.recording;
    const auto first = static_cast<Eigen::Index>(window.first), size = static_cast<Eigen::Index>(window.samples());
    const Eigen::MatrixXd measured = data[r].position.middleRows(first, size);
    const std::vector<double>& t = data[r].time;
    if (r != of) {
      memory.clear();
      hidden = list[r].hidden_at_rest();
      of = r;
      reached = 0;
    }
    if (!model.remainder.empty()) {
      memory = remember(model.remainder, data[r], paths[r], reached, window.first, std::move(memory));
    }
    hidden = window.opens ? list[r].hidden_at_rest()
                          : list[r].hidden_after(std::move(hidden), t, paths[r].position, paths[r].velocity, drives[r],
                                                 reached, window.first);
    reached = window.first;
    const auto run = [&](const SegmentState& x, Eigen::MatrixXd* states) {
      const std::vector<Drive> own = own_drives(list[r], data[r], window, x);
      return list[r].run(x.head(2 * n), t, own.empty() ? drives[r] : own, window.first, window.last, max_step,
                         hidden_states_of(x, hidden), states, memory);
    };
    SegmentState start = initial_guess(window, paths[r], list[r]);
    result.samples += static_cast<double>(size * n);
    Eigen::MatrixXd error;
    try {
      start =
          fit_initial_state([&](const SegmentState& x) -> Eigen::MatrixXd { return measured - run(x, nullptr); }, start,
                            kSettings.fit.free_run_iterations, precision_of(start, data[r]), reach_of(start, list[r]))
              .start;
      hidden = hidden_states_of(start, std::move(hidden));
      if (window.opens && list[r].has_plays()) {
        plays[r].push_back({window.first, plays_of(start, n)});
        drives[r] = drives_of(list[r], data[r], plays[r]);
      }
      Eigen::MatrixXd states;
      const Eigen::MatrixXd simulated = run(start, &states);
      error = measured - simulated;
      result.simulated[r].middleRows(first, size) = simulated;
      result.velocity[r].middleRows(first, size) = states.rightCols(n);
    } catch (const NumericalError&) {
      error = measured.rowwise() - measured.colwise().mean();
    }
    result.window_rms.push_back(std::sqrt(error.squaredNorm() / static_cast<double>(size * n)));
    joint_squares += error.colwise().squaredNorm().transpose();
    squares += result.window_rms.back() * result.window_rms.back() * static_cast<double>(size * n);
  }
  result.rms = std::sqrt(squares / std::max(1.0, result.samples));
  result.joint_rms = (joint_squares * n / std::max(1.0, result.samples)).cwiseSqrt();
  return result;
}

}  // namespace bayesctrl
