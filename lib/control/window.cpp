#include "control/window.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr int kPieces = 4;               // of a control period, on which delays lie
constexpr double kMostDelays = 60.0;     // of the grid of delays
constexpr double kSmallestRest = 1e-20;  // of a sum of squares: what rounding leaves
constexpr double kTellingShare = 1e-8;   // of an input's motion that no drift could have made
constexpr double kTold = 5.0;            // nats between delays that are told apart
constexpr int kEnoughProbes = 4;         // after which what noise hides does not matter

/// Columns 1, s, s^2 / 2, s^3 / 6 of the first `count` powers.
Eigen::MatrixXd powers(const Eigen::VectorXd& s, int count) {
  Eigen::MatrixXd columns(s.size(), count);
  columns.col(0).setOnes();
  for (int i = 1; i < count; ++i) columns.col(i) = columns.col(i - 1).cwiseProduct(s) / i;
  return columns;
}

Eigen::VectorXd times_around_middle(int samples, double dt) {
  return Eigen::VectorXd::LinSpaced(samples, -0.5 * dt * (samples - 1), 0.5 * dt * (samples - 1));
}

}  // namespace

History::History(int joints, int capacity)
    : joints_(joints),
      capacity_(capacity),
      seen_(static_cast<std::size_t>(capacity), StateVector::Zero(2 * joints)),
      inputs_(static_cast<std::size_t>(capacity), JointVector::Zero(joints)) {}

void History::add(const StateVector& seen) {
  seen_[static_cast<std::size_t>(calls_ % capacity_)] = seen;
  ++calls_;
}

void History::hold(const JointVector& input) {
  inputs_[static_cast<std::size_t>((calls_ - 1) % capacity_)] = input;
  held_ = calls_;
}

JointVector History::input(long k) const {
  if (k < 0 || held_ == 0) return JointVector::Zero(joints_);
  return inputs_[static_cast<std::size_t>(std::clamp(k, std::max(0L, held_ - capacity_), held_ - 1) % capacity_)];
}

WindowFit::WindowFit(int samples, double dt, bool positions_only)
    : positions_only_(positions_only), times_(times_around_middle(samples, dt)) {
  basis_ = powers(times_, positions_only ? 4 : 3);
  weights_ = basis_.completeOrthogonalDecomposition().pseudoInverse();
  acceleration_variance_ = weights_.row(positions_only ? 2 : 1).squaredNorm();
}

WindowFit::Result WindowFit::operator()(const Eigen::VectorXd& positions, const Eigen::VectorXd& velocities) const {
  const Eigen::VectorXd& y = positions_only_ ? positions : velocities;
  const Eigen::VectorXd c = weights_ * y;
  const double rest = (y - basis_ * c).squaredNorm();
  if (positions_only_) return {c[0], c[1], c[2], c[3], rest};
  const Eigen::MatrixXd integrated = powers(times_, 4).rightCols(3);
  return {(positions - integrated * c).mean(), c[0], c[1], c[2], rest};
}

InputMotion motion_of_input(const History& history, int input, long first, int samples, double dt,
                            const Timing& timing) {
  const double h = dt / kPieces;
  const auto delay = static_cast<long>(std::lround(timing.delay / h));
  const auto before = timing.lag > 0.0 ? static_cast<long>(std::ceil(5.0 * timing.lag / h)) : 0L;
  const double decay = timing.lag > 0.0 ? std::exp(-h / timing.lag) : 0.0;
  const auto commanded = [&](long piece) {  // piece 0 begins at call `first`
    const long at = piece - delay;
    const long call = first + (at >= 0 ? at / kPieces : -((-at + kPieces - 1) / kPieces));
    return history.input(call)[input];
  };

  InputMotion motion{0.0, Eigen::VectorXd::Zero(samples), Eigen::VectorXd::Zero(samples)};
  double acting = commanded(-before), once = 0.0, twice = 0.0;
  const long pieces = static_cast<long>(samples - 1) * kPieces;
  for (long piece = -before; piece < pieces; ++piece) {
    const double u = commanded(piece);
    const double mean = timing.lag > 0.0 ? u + (acting - u) * timing.lag * (1.0 - decay) / h : u;
    acting = u + (acting - u) * decay;
    if (piece < 0) continue;
    twice += h * (once + 0.5 * h * mean);
    once += h * mean;
    if ((piece + 1) % kPieces == 0) {
      motion.once[(piece + 1) / kPieces] = once;
      motion.twice[(piece + 1) / kPieces] = twice;
    }
  }
  motion.mean = once / (dt * (samples - 1));
  return motion;
}

namespace {

/// Positions, or velocities where they are measured, of the calls from `first`: samples x joints.
Eigen::MatrixXd seen_motion(const History& history, long first, int samples, bool positions_only) {
  const int joints = history.joints();
  Eigen::MatrixXd motion(samples, joints);
  for (int i = 0; i < joints; ++i) {
    for (int k = 0; k < samples; ++k) motion(k, i) = history.seen(first + k)[positions_only ? i : joints + i];
  }
  return motion;
}

}  // namespace

JumpFit fit_jump(const History& history, int input, long first, long last, double dt, bool positions_only,
                 const Timings& timings, const JointMatrix& believed) {
  const int samples = static_cast<int>(last - first + 1), joints = history.joints();
  const int columns = positions_only ? 4 : 3;
  const JointVector none = JointVector::Zero(joints);
  JumpFit fit{none, none, none, none, 0};
  if (samples < columns + 3) return fit;
  Eigen::MatrixXd motion = seen_motion(history, first, samples, positions_only), basis(samples, columns + 1);
  Eigen::MatrixXd richer(samples, columns + 2);
  richer.leftCols(columns + 1) = powers(times_around_middle(samples, dt), columns + 1);
  basis.leftCols(columns) = richer.leftCols(columns);
  for (int j = 0; j < joints; ++j) {
    const InputMotion acting = motion_of_input(history, j, first, samples, dt, timings[static_cast<std::size_t>(j)]);
    const Eigen::VectorXd& shape = positions_only ? acting.twice : acting.once;
    if (j == input) {
      basis.col(columns) = shape;
    } else {
      motion -= shape * believed.col(j).transpose();
    }
  }
  const Eigen::VectorXd shape = basis.col(columns);
  const Eigen::VectorXd alone = shape - basis.leftCols(columns) * basis.leftCols(columns).householderQr().solve(shape);
  const double squares = alone.squaredNorm();
  if (!(squares > kTellingShare * shape.squaredNorm())) return fit;
  richer.col(columns + 1) = shape;
  fit.degrees_of_freedom = samples - columns - 1;
  const auto solver = basis.householderQr(), richer_solver = richer.householderQr();
  for (int i = 0; i < joints; ++i) {
    const Eigen::VectorXd y = motion.col(i), c = solver.solve(y);
    fit.gain[i] = c[columns];
    fit.bias[i] = richer_solver.solve(y)[columns + 1] - c[columns];
    fit.factor[i] = 1.0 / squares;
    fit.rest[i] = (y - basis * c).squaredNorm();
  }
  return fit;
}

Timing latest(const Timings& timings) {
  const auto later = [](const Timing& a, const Timing& b) { return a.together() < b.together(); };
  return timings.empty() ? Timing{} : *std::max_element(timings.begin(), timings.end(), later);
}

TimingEstimate::TimingEstimate(int inputs, double longest, double dt, bool positions_only)
    : dt_(dt), positions_only_(positions_only), best_(static_cast<std::size_t>(inputs)) {
  // Whole pieces, and no more than so many: a probe asks each of them.
  const double h = dt / kPieces * std::max(1.0, std::ceil(longest / (dt / kPieces) / kMostDelays));
  const auto count = static_cast<int>(std::floor(longest / h + 0.5));
  for (int late = 0; late <= count; ++late) {
    for (int lag = 0; late + lag <= count; lag += 2) grid_.push_back({late * h, lag * h});
  }
  OfInput begun{grid_.size() <= 1, 0, {}};
  for (const Timing& timing : grid_) begun.log_likelihood.push_back(-timing.together() / dt);  // late is unusual
  inputs_.assign(best_.size(), begun);
}

bool TimingEstimate::add(const History& history, long first, long last) {
  const int samples = static_cast<int>(last - first + 1), joints = history.joints();
  const int columns = positions_only_ ? 4 : 3;
  if (samples < columns + joints + 2 || grid_.size() < 2) return false;
  std::vector<int> changing;  // inputs, without which nothing is told
  for (int j = 0; j < joints; ++j) {
    bool changes = false;
    for (long k = first - 1; k < last; ++k) changes = changes || history.input(k)[j] != history.input(k + 1)[j];
    if (changes) changing.push_back(j);
  }
  if (changing.size() != 1) return false;
  const auto input = static_cast<std::size_t>(changing.front());
  OfInput& told = inputs_[input];
  Timing& best = best_[input];
  const Eigen::MatrixXd motion = seen_motion(history, first, samples, positions_only_);
  Eigen::MatrixXd basis(samples, columns + joints);
  basis.leftCols(columns) = powers(times_around_middle(samples, dt_), columns);
  const auto place = [&](int j, const Timing& timing) {
    const InputMotion acting = motion_of_input(history, j, first, samples, dt_, timing);
    basis.col(columns + j) = positions_only_ ? acting.twice : acting.once;
  };
  for (int j = 0; j < joints; ++j) place(j, best_[static_cast<std::size_t>(j)]);
  double highest = 0.0;
  for (std::size_t g = 0; g < grid_.size(); ++g) {
    place(changing.front(), grid_[g]);
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(basis);
    for (int i = 0; i < joints; ++i) {
      const double rest = (motion.col(i) - basis * solver.solve(motion.col(i))).squaredNorm();
      told.log_likelihood[g] -= 0.5 * samples * std::log(rest + kSmallestRest);
    }
    if (g == 0 || told.log_likelihood[g] > highest) {
      highest = told.log_likelihood[g];
      best = grid_[g];
    }
  }
  // Known as soon as what acts more than a period earlier or later is worse.
  double other = -kInfinity;
  for (std::size_t g = 0; g < grid_.size(); ++g) {
    const double apart = std::abs(grid_[g].together() - best.together());
    if (apart > 1.1 * dt_) other = std::max(other, told.log_likelihood[g]);
  }
  told.known = ++told.probes >= kEnoughProbes || highest - other > kTold;
  return true;
}

bool TimingEstimate::known() const {
  return std::all_of(inputs_.begin(), inputs_.end(), [](const OfInput& input) { return input.known; });
}

}  // namespace bayesctrl
