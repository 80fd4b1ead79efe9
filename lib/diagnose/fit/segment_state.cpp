#include "diagnose/fit/segment_state.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr int kPieces = 4;            // of a step whose input is a straight line
constexpr double kLittle = 1e-3;      // of the squares: no round that gains less is worth it
constexpr double kAsPromised = 0.05;  // of the gain by which it misses what the jacobian promised: they hold further

}  // namespace

SegmentState initial_guess(const Segment& window, const Trajectory& path, const Machine& machine) {
  const auto row = static_cast<Eigen::Index>(window.first);
  const Eigen::Index n = path.position.cols();
  const bool unknown = (machine.hidden_count() > 0 && window.after_gap) || (machine.has_lags() && window.opens);
  SegmentState start = SegmentState::Zero(2 * n + (unknown ? machine.hidden_count() + n : 0));
  start.head(2 * n) << path.position.row(row).transpose(), path.velocity.row(row).transpose();
  return start;
}

void hand_down(const SegmentState& found, int joint_count, SegmentState& start) {
  const Eigen::Index n = joint_count, states = 2 * n;
  start.head(states) = found.head(states);
  if (start.size() == states || found.size() == states) return;
  start.tail(n) = found.tail(n);
  if (start.size() == found.size()) start = found;
}

HiddenStates hidden_states_of(const SegmentState& start, const Segment& window, HiddenStates known) {
  const Eigen::Index n = known.lags.size();
  if (start.size() > 2 * n) {
    if (window.after_gap) known.effects = start.segment(2 * n, start.size() - 3 * n);
    known.lags = start.tail(n);
  }
  return known;
}

SegmentState precision_of(const SegmentState& start, const Measured& data) {
  SegmentState precision = SegmentState::Zero(start.size());
  const Eigen::Index n = data.input.cols();
  if (start.size() > 2 * n) {
    for (Eigen::Index j = 0; j < n; ++j) {
      precision[start.size() - n + j] =
          1.0 / std::max(1e-12, data.input.col(j).squaredNorm() / static_cast<double>(data.samples()));
    }
  }
  return precision;
}

SegmentState weights_of(const SegmentState& precision, const Eigen::MatrixXd& residual) {
  return precision * (residual.squaredNorm() / static_cast<double>(residual.size()));
}

SegmentState fit_initial_state(const std::function<Eigen::MatrixXd(const SegmentState&)>& residual_of, SegmentState x,
                               int rounds, const SegmentState& precision) {
  Eigen::MatrixXd residual = residual_of(x), jacobian(residual.size(), x.size());
  double damping = 1e-6;
  bool jacobian_holds = false;  // near enough those of the present start
  for (int round = 0; round < rounds; ++round) {
    for (Eigen::Index i = 0; i < x.size() && !jacobian_holds; ++i) {
      SegmentState moved = x;
      moved[i] += kSegmentStateStep;
      jacobian.col(i) = ((residual - residual_of(moved)) / kSegmentStateStep).reshaped();
    }
    const SegmentState weight = weights_of(precision, residual);
    const auto cost = [&](const Eigen::MatrixXd& left, const SegmentState& at) {
      return left.squaredNorm() + weight.dot(at.cwiseAbs2());
    };
    Eigen::MatrixXd curvature = jacobian.transpose() * jacobian;
    curvature.diagonal() += weight;
    const Eigen::VectorXd gradient = jacobian.transpose() * residual.reshaped() - weight.cwiseProduct(x);
    const double before = cost(residual, x), largest = curvature.diagonal().maxCoeff();
    double gained = 0.0, promised = 0.0;
    for (int trial = 0; trial < 6 && gained <= 0.0; ++trial, damping *= gained > 0.0 ? 1.0 : 30.0) {
      Eigen::MatrixXd damped = curvature;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-14 * largest;
      const SegmentState change = damped.ldlt().solve(gradient), next = x + change;
      promised = 2.0 * change.dot(gradient) - change.dot(curvature * change);
      if (promised <= kLittle * before) return x;
      Eigen::MatrixXd tried;
      try {
        tried = residual_of(next);
      } catch (const NumericalError&) {
        continue;
      }
      gained = before - cost(tried, next);
      if (gained > 0.0) {
        x = next;
        residual = tried;
        damping *= 0.1;
      }
      if (jacobian_holds) break;  // no use in shorter steps along an old Jacobian
    }
    if (gained <= kLittle * before) {
      if (!jacobian_holds || gained > 0.0) break;
      jacobian_holds = false;
    } else {
      jacobian_holds = std::abs(gained - promised) < kAsPromised * promised;
    }
  }
  return x;
}

std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, std::size_t recordings) {
  std::vector<Machine> list;
  for (std::size_t r = 0; r < recordings; ++r) {
    std::vector<Effect> here;
    for (const Effect& effect : effects) {
      if (effect.recording < 0 || static_cast<std::size_t>(effect.recording) == r) here.push_back(effect);
    }
    list.emplace_back(plant, std::move(here));
  }
  return list;
}

std::vector<Drive> drives_of(const Machine& machine, const Measured& data) {
  if (!data.linear_hold) return machine.drives(data.time, data.input);
  std::vector<double> time;
  Eigen::MatrixXd input((data.input.rows() - 1) * kPieces + 1, data.input.cols());
  for (std::size_t k = 0; k + 1 < data.samples(); ++k) {
    for (int i = 0; i < kPieces; ++i) {
      input.row(static_cast<Eigen::Index>(time.size())) = input_at(data, k, (i + 0.5) / kPieces).transpose();
      time.push_back(data.time[k] + (data.time[k + 1] - data.time[k]) * i / kPieces);
    }
  }
  input.row(static_cast<Eigen::Index>(time.size())) = data.input.row(data.input.rows() - 1);
  time.push_back(data.time.back());
  return machine.drives(time, input);
}

}  // namespace bayesctrl
