#include "diagnose/verdict/uncertainty.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr std::size_t kStates = 500;  // that stand for all samples
constexpr double kLeast = 1e-9;       // a process needs some variance

/// Samples that stand for the recorded motion.
struct Visited {
  std::vector<JointVector> q, v, u, missing_torque, celsius;
};

Visited visited(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed) {
  std::size_t samples = 0;
  for (const Measured& m : data) samples += m.samples();
  const std::size_t stride = (samples + kStates - 1) / kStates;
  Visited list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (Eigen::Index k = 0; k < data[r].position.rows(); k += static_cast<Eigen::Index>(stride)) {
      list.q.emplace_back(smoothed[r].position.row(k).transpose());
      list.v.emplace_back(smoothed[r].velocity.row(k).transpose());
      list.u.emplace_back(data[r].input.row(k).transpose());
      list.missing_torque.emplace_back(smoothed[r].missing_torque.row(k).transpose());
      list.celsius.push_back(celsius_at(data[r].temperature, data[r].time[static_cast<std::size_t>(k)]));
    }
  }
  return list;
}

/// Column per state: a, then b column after column with the logarithm of b_ii on its diagonal.
Eigen::MatrixXd values_along(const Model& model, const Visited& states) {
  const Eigen::Index n = states.q.front().size();
  Eigen::MatrixXd values(n + n * n, static_cast<Eigen::Index>(states.q.size()));
  for (std::size_t k = 0; k < states.q.size(); ++k) {
    Affine at = affine(model, states.q[k], states.v[k], states.celsius[k]);
    at.gain.diagonal() = at.gain.diagonal().array().max(kLeast).log();
    values.col(static_cast<Eigen::Index>(k)) << at.drift, at.gain.reshaped();
  }
  return values;
}

/// Mean squares of what the parameters' covariance leaves open of these values.
Eigen::VectorXd left_open(const Corrected& model, const Fit& fit, const Visited& states, Eigen::Index values) {
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(values);
  const auto count = static_cast<Eigen::Index>(fit.unknowns.size());
  if (fit.covariance.rows() != count || !fit.covariance.allFinite()) return squares;
  std::vector<Eigen::MatrixXd> slopes;
  Fit moved = fit;
  for (const Unknown& unknown : fit.unknowns) {
    const auto at = [&](double value) {
      Unknown other = unknown;
      other.value = value;
      put(moved, other);
      return values_along({moved.plant, in_new_recordings(moved.effects), model.remainder}, states);
    };
    const double above = unknown.above(), below = unknown.below();
    slopes.emplace_back((at(above) - at(below)) / std::max(above - below, kLeast));
    put(moved, unknown);
  }
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) {
      const auto a = static_cast<std::size_t>(i), b = static_cast<std::size_t>(j);
      squares += fit.covariance(i, j) * slopes[a].cwiseProduct(slopes[b]).rowwise().mean();
    }
  }
  return squares.cwiseMax(0.0);
}

}  // namespace

ModelUncertainty uncertainty_of(const Corrected& model, const Fit& fit, const Plant& nominal,
                                const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed,
                                const Eigen::VectorXd& left) {
  const Visited states = visited(data, smoothed);
  const Eigen::Index n = states.q.front().size();
  const Eigen::VectorXd open = left_open(model, fit, states, n + n * n);
  Eigen::ArrayXd missing = Eigen::ArrayXd::Zero(n), input = missing, gain = missing;  // mean squares
  const auto count = static_cast<double>(states.q.size());
  const Model machine{model.plant, in_new_recordings(model.effects)};
  for (std::size_t k = 0; k < states.q.size(); ++k) {
    const JointMatrix b = affine(machine, states.q[k], states.v[k], states.celsius[k]).gain;
    const JointMatrix mobility = motion(nominal, states.q[k], states.v[k], states.u[k], 0.0).mobility;
    missing += (mobility * states.missing_torque[k]).array().square() / count;
    input += states.u[k].array().square() / count;
    gain += b.diagonal().array().square() / count;
  }
  ModelUncertainty result;
  const auto sd = [](double square) { return std::max(std::sqrt(square), kLeast); };
  for (Eigen::Index i = 0; i < n; ++i) {
    const double unexplained = left[i] * left[i] * missing[i];
    // An error of b shows as far as there is input; where there is none, b may be as wrong as it is large.
    const auto shown = [&](Eigen::Index j) { return std::min(unexplained / std::max(input[j], kLeast), gain[i]); };
    result.drift.push_back(sd(open[i] + unexplained));
    result.input_gain.push_back(sd(open[n + i * n + i] + shown(i) / std::max(gain[i], kLeast)));
    if (n == 1) continue;
    double squares = 0.0;
    for (Eigen::Index j = 0; j < n; ++j) {
      if (j != i) squares += (open[n + j * n + i] + shown(j)) / static_cast<double>(n - 1);
    }
    result.coupling.push_back(sd(squares));
  }
  return result;
}

}  // namespace bayesctrl
