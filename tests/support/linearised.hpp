#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "base/random.hpp"
#include "diagnose/fit/fit.hpp"
#include "diagnose/fit/runs.hpp"
#include "physics/machine/machine.hpp"
#include "support/dense.hpp"

namespace bayesctrl::testing {

/// An effect as a trial may draw it for a machine that is moved by some 2 N m.
template <class E>
E drawn_effect(double strength) {
  RandomStream random = random_stream(5, E::kName);
  const auto uniform = [&](double low, double high) { return draw_uniform(random, low, high); };
  return E::drawn(uniform, DrawScales{strength, 2.0, 2.5, 1.0, 3.0, 4.0});
}

/// Of all seven joints that a machine may have, from 25 to 45 degrees Celsius within 6 s.
inline RecordedTemperature warming() {
  Temperature rising{{0.0, 6.0}, Eigen::MatrixXd(2, kMaxJoints)};
  rising.celsius.row(0).setConstant(25.0);
  rising.celsius.row(1).setConstant(45.0);
  return std::make_shared<const Temperature>(std::move(rising));
}

/// How any machine is to be recorded.
struct Recipe {
  double seconds = 6.0;
  double period = 0.01;  // s
  double noise = 0.0;
  double strength = 1.0;  // of the input: a sum of sines
  double gap = -1.0;      // s, from where on half a second is lost; none if negative
  double phase = 0.4;     // of the sines
  double position = 0.3;  // of all joints at first, at rest
  double departed = 0.0;  // of the outputs of lags from the first input
  double play = 0.0;      // of plays from the middle of their gap about the first input
  std::uint64_t seed = 1;
};

/// What was recorded, and [q, v] as they were.
struct Recorded {
  Measured data;
  Trajectory truth;
};

inline Recorded recorded(const Machine& machine, const Recipe& recipe) {
  const int n = machine.joints();
  const auto count = static_cast<Eigen::Index>(std::lround(recipe.seconds / recipe.period));
  std::vector<double> time;
  Eigen::MatrixXd input(count, n), states;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double t = time.emplace_back(recipe.period * static_cast<double>(k));
    for (int j = 0; j < n; ++j) {
      input(k, j) = recipe.strength * (2.5 * std::sin(1.1 * t + recipe.phase + j) + 1.5 * std::sin((3.7 - j) * t) +
                                       std::sin(7.9 * t + recipe.phase));
    }
  }
  StateVector start(2 * n);
  start << JointVector::Constant(n, recipe.position), JointVector::Zero(n);
  const std::vector<Drive> drives = machine.drives(time, input, nullptr, {{0, JointVector::Constant(n, recipe.play)}});
  Eigen::MatrixXd q = machine.run(start, time, drives, 0, time.size() - 1, 1e-3,
                                  {{}, JointVector::Constant(n, recipe.departed)}, &states);
  RandomStream random(recipe.seed);
  for (double& x : q.reshaped()) x += recipe.noise * draw_normal(random);
  std::vector<Eigen::Index> kept;
  for (Eigen::Index k = 0; k < count; ++k) {
    const double t = time[static_cast<std::size_t>(k)];
    if (recipe.gap < 0.0 || t < recipe.gap - 1e-9 || t >= recipe.gap + 0.5) kept.push_back(k);
  }
  Recorded result{{"test", {}, q(kept, Eigen::all), input(kept, Eigen::all), 0.0, false}, {}};
  for (const Eigen::Index k : kept) result.data.time.push_back(time[static_cast<std::size_t>(k)]);
  result.data.temperature = machine.temperature();
  result.truth.position = states(kept, Eigen::all).leftCols(n);
  result.truth.velocity = states(kept, Eigen::all).rightCols(n);
  result.truth.missing_torque = result.truth.torque_sd = Eigen::MatrixXd::Zero(result.truth.position.rows(), n);
  result.truth.velocity_sd = Eigen::MatrixXd::Constant(result.truth.position.rows(), n, 1e-6);
  return result;
}

/// Recordings that are linearised about the true motion, for fits of a model to them.
class Linearised {
 public:
  /// `nominal`: the model. `window`: s.
  Linearised(const Plant& nominal, const std::vector<Recorded>& recordings, double noise, double window = 2.0)
      : data(column(recordings, &Recorded::data)),
        paths(column(recordings, &Recorded::truth)),
        response(nominal, data, paths, Eigen::VectorXd::Constant(joints(nominal), noise), windows(data, window)),
        forcing(nominal, data, paths),
        problem{nominal, nominal, {}, data, response, forcing} {
    problem.max_step = 2e-3;
    problem.penalty = 3.0;
  }
  Linearised(const Linearised&) = delete;  // the parts refer to one another

  const std::vector<Measured> data;
  const std::vector<Trajectory> paths;
  const LinearResponse response;
  const Forcing forcing;
  FitProblem problem;

  /// A model as it is given, its segments beginning where the machine was; nothing is simulated yet.
  Fit at_truth(std::vector<Effect> effects) const {
    Fit fit;
    fit.plant = problem.nominal;
    fit.effects = std::move(effects);
    fit.unknowns = list_unknowns(fit.plant, problem.given, fit.effects, problem.free, data, paths);
    const std::vector<Machine> list = machines(fit.plant, fit.effects, data);
    for (const Segment& window : response.windows()) {
      const Trajectory& path = paths[window.recording];  // of the machine, not of what its sensors show
      SegmentState& start = fit.initial_states.emplace_back(initial_guess(window, path, list[window.recording]));
      const auto row = static_cast<Eigen::Index>(window.first);
      start.head(2 * path.position.cols()) << path.position.row(row).transpose(), path.velocity.row(row).transpose();
    }
    fit.residual = Eigen::VectorXd::Zero(response.rows());
    return fit;
  }

  /// The initial state of a segment that leaves least of its samples: Gauss-Newton steps along central differences at
  /// the first.
  static SegmentState best_start(const Runs& runs, std::size_t w, SegmentState x) {
    constexpr double kStep = 1e-6;
    constexpr int kSteps = 4;
    Eigen::MatrixXd residual = runs.residual(w, x), slope(residual.size(), x.size());
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const SegmentState step = kStep * SegmentState::Unit(x.size(), i);
      slope.col(i) = ((runs.residual(w, x + step) - runs.residual(w, x - step)) / (2.0 * kStep)).reshaped();
    }
    for (int step = 0; step < kSteps; ++step) {
      x -= SegmentState(dense::least_squares(slope, residual.reshaped()).col(0));
      residual = runs.residual(w, x);
    }
    return x;
  }

  /// Rows of a model whose segments all begin so.
  Eigen::VectorXd rows_of(const Fit& fit) const {
    const Runs runs(problem, fit);
    Eigen::VectorXd rows(response.rows());
    for (std::size_t w = 0; w < fit.initial_states.size(); ++w) {
      rows.segment(response.first_row(w), response.row_count(w)) =
          response.project(w, runs.residual(w, best_start(runs, w, fit.initial_states[w])));
    }
    return rows;
  }

  /// How fast those rows fall with the unknown i: by central differences of +-h.
  Eigen::VectorXd slope_of(const Fit& fit, Eigen::Index i, double h) const {
    const auto at = [&](double value) {
      Fit moved = fit;
      Eigen::VectorXd values = values_of(fit);
      values[i] = value;
      assign(moved, values);
      return rows_of(moved);
    };
    const double here = values_of(fit)[i];
    return (at(here - h) - at(here + h)) / (2.0 * h);
  }

 private:
  template <class Part>
  static std::vector<Part> column(const std::vector<Recorded>& recordings, Part Recorded::*part) {
    std::vector<Part> list;
    for (const Recorded& one : recordings) list.push_back(one.*part);
    return list;
  }
};

}  // namespace bayesctrl::testing
