#include "diagnose/fit/segment_state.hpp"

#include <algorithm>

#include "base/error.hpp"
#include "diagnose/settings.hpp"
#include "numerics/least_squares.hpp"

namespace bayesctrl {

SegmentState initial_guess(const Segment& window, const Trajectory& path, const Machine& machine) {
  const auto row = static_cast<Eigen::Index>(window.first);
  const Eigen::Index n = path.position.cols();
  const bool unknown = window.opens && (machine.hidden_count() > 0 || machine.has_lags() || machine.has_plays());
  SegmentState start = SegmentState::Zero(2 * n + (unknown ? machine.hidden_count() + 2 * n : 0));
  start.head(n) = machine.unmeasured(path.position.row(row).transpose());
  start.segment(n, n) = path.velocity.row(row).transpose().cwiseQuotient(machine.measured_scale());
  return start;
}

void hand_down(const SegmentState& found, int joint_count, SegmentState& start) {
  const Eigen::Index n = joint_count, states = 2 * n;
  start.head(states) = found.head(states);
  if (start.size() == states || found.size() == states) return;
  start.tail(2 * n) = found.tail(2 * n);
  if (start.size() == found.size()) start = found;
}

HiddenStates hidden_states_of(const SegmentState& start, HiddenStates known) {
  const Eigen::Index n = known.lags.size();
  if (start.size() > 2 * n) known = {start.segment(2 * n, start.size() - 4 * n), start.tail(2 * n).head(n)};
  return known;
}

JointVector plays_of(const SegmentState& start, int joint_count) {
  return start.size() > 2 * joint_count ? JointVector(start.tail(joint_count)) : JointVector{};
}

SegmentState precision_of(const SegmentState& start, const Measured& data) {
  SegmentState precision = SegmentState::Zero(start.size());
  const Eigen::Index n = data.input.cols();
  if (start.size() > 2 * n) {
    const Eigen::VectorXd squares = data.input.colwise().squaredNorm() / static_cast<double>(data.samples());
    precision.tail(2 * n) = squares.cwiseMax(1e-12).cwiseInverse().replicate(2, 1);
  }
  return precision;
}

SegmentState reach_of(const SegmentState& start, const Machine& machine) {
  const Eigen::Index n = machine.joints();
  if (!machine.has_plays() || start.size() == 2 * n) return {};
  SegmentState reach = SegmentState::Constant(start.size(), kInfinity);
  reach.tail(n) = machine.reach();
  return reach;
}

SegmentState within(SegmentState start, const SegmentState& reach) {
  return reach.size() > 0 ? SegmentState(start.cwiseMin(reach).cwiseMax(-reach)) : start;
}

double state_step(const SegmentState& start, Eigen::Index component, const SegmentState& reach) {
  const bool ends = reach.size() > 0 && start[component] + kSegmentStateStep > reach[component];
  return ends ? -kSegmentStateStep : kSegmentStateStep;
}

SegmentState weights_of(const SegmentState& precision, const Eigen::MatrixXd& residual) {
  return precision * (residual.squaredNorm() / static_cast<double>(residual.size()));
}

namespace {

/// What an initial state leaves of its segment. Runs are expensive: the Jacobian is kept while steps do what it
/// promises.
class Shot {
 public:
  Shot(const std::function<Eigen::MatrixXd(const SegmentState&)>& residual_of, const SegmentState& precision,
       const SegmentState& reach)
      : residual_of_(residual_of), precision_(precision), reach_(reach) {}

  SegmentRun at(const SegmentState& x) const { return {x, residual_of_(x)}; }

  double cost(const SegmentRun& tried) const {
    return 0.5 * (tried.residual.squaredNorm() + weight_.dot(tried.start.cwiseAbs2()));
  }

  QuadraticModel model(const SegmentRun& now, double agreement) {
    QuadraticModel model;
    model.kept = jacobian_.size() > 0 && agreement < kSettings.fit.kept_jacobian;
    if (!model.kept) differentiate(now);
    weight_ = weights_of(precision_, now.residual);
    model.hessian = jacobian_.transpose() * jacobian_;
    model.hessian.diagonal() += weight_;
    model.descent = jacobian_.transpose() * now.residual.reshaped() - weight_.cwiseProduct(now.start);
    if (reach_.size() > 0) {
      model.low = -reach_ - now.start;
      model.high = reach_ - now.start;
    }
    return model;
  }

  SegmentRun moved(const SegmentRun& from, const Eigen::VectorXd& step) const {
    return at(from.start + SegmentState(step));
  }

 private:
  void differentiate(const SegmentRun& now) {
    jacobian_.resize(now.residual.size(), now.start.size());
    for (Eigen::Index i = 0; i < now.start.size(); ++i) {
      const double step = state_step(now.start, i, reach_);
      SegmentState moved = now.start;
      moved[i] += step;
      jacobian_.col(i) = ((now.residual - residual_of_(moved)) / step).reshaped();
    }
  }

  const std::function<Eigen::MatrixXd(const SegmentState&)>& residual_of_;
  const SegmentState& precision_;
  const SegmentState& reach_;
  SegmentState weight_;
  Eigen::MatrixXd jacobian_;
};

}  // namespace

SegmentRun fit_initial_state(const std::function<Eigen::MatrixXd(const SegmentState&)>& residual,
                             const SegmentState& start, int rounds, const SegmentState& precision,
                             const SegmentState& reach) {
  const auto from = [&](const SegmentState& there) {
    Shot shot(residual, precision, reach);
    SegmentRun best = shot.at(there);
    least_squares(shot, best,
                  {.max_iterations = rounds,
                   .max_trials = kSettings.fit.segment_trials,
                   .damping = kSettings.fit.segment_damping,
                   .growth = kSettings.fit.segment_growth,
                   .rejected = 0.0,
                   .least_relative_gain = kSettings.fit.segment_gain,
                   .least_promise = kSettings.fit.segment_gain});
    return best;
  };
  SegmentRun best = from(within(start, reach));
  for (const double end : {-1.0, 1.0}) {  // what has ends is not smooth in between, and often stands at one of them
    if (reach.size() == 0) break;
    const SegmentState there = reach.array().isFinite().select(end * reach, start);
    try {
      SegmentRun other = from(there);
      if (other.residual.squaredNorm() < best.residual.squaredNorm()) best = std::move(other);
    } catch (const NumericalError&) {  // diverges from there
    }
  }
  return best;
}

std::vector<Machine> machines(const Plant& plant, const std::vector<Effect>& effects, const std::vector<Measured>& data,
                              const Remainder& remainder) {
  std::vector<Machine> list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    list.emplace_back(plant, acting_in(effects, r), remainder, data[r].temperature);
  }
  return list;
}

std::vector<Drive> drives_of(const Machine& machine, const Measured& data, const Restarts& plays, std::size_t samples) {
  Restarts restarts;
  if (machine.has_delays()) restarts = restarts_of(data);
  for (const Restart& known : plays) {
    const auto at = std::ranges::lower_bound(restarts, known.sample, {}, &Restart::sample);
    if (at != restarts.end() && at->sample == known.sample) {
      at->plays = known.plays;
    } else {
      restarts.insert(at, known);
    }
  }
  const std::size_t count = samples > 0 ? samples : data.samples();
  const auto rows = static_cast<Eigen::Index>(count);
  if (!data.linear_hold) {
    const std::vector<double> begins(data.time.begin(), data.time.begin() + rows);
    return machine.drives(begins, data.input.topRows(rows), data.fine.get(), restarts);
  }
  std::vector<double> time;
  Eigen::MatrixXd input((rows - 1) * kSettings.fit.linear_hold_pieces + 1, data.input.cols());
  for (std::size_t k = 0; k + 1 < count; ++k) {
    for (int i = 0; i < kSettings.fit.linear_hold_pieces; ++i) {
      input.row(static_cast<Eigen::Index>(time.size())) =
          input_at(data, k, (i + 0.5) / kSettings.fit.linear_hold_pieces).transpose();
      time.push_back(data.time[k] + (data.time[k + 1] - data.time[k]) * i / kSettings.fit.linear_hold_pieces);
    }
  }
  input.row(static_cast<Eigen::Index>(time.size())) = data.input.row(rows - 1);
  time.push_back(data.time[count - 1]);
  for (Restart& restart : restarts) restart.sample *= static_cast<std::size_t>(kSettings.fit.linear_hold_pieces);
  return machine.drives(time, input, nullptr, restarts);
}

std::vector<Drive> own_drives(const Machine& machine, const Measured& data, const Segment& window,
                              const SegmentState& start) {
  if (!window.opens || !machine.has_plays()) return {};
  return drives_of(machine, data, {{window.first, plays_of(start, machine.joints())}}, window.last + 1);
}

}  // namespace bayesctrl
