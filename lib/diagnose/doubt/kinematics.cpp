#include "diagnose/doubt/kinematics.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/fields.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

/// A Gaussian and its derivatives as weights of samples from -reach to reach, exact for polynomials of second degree.
/// What it leaves is smooth: samples a quarter of its width apart hold all of it, so a second pass has stride 1.
struct Filter {
  Eigen::Index reach = 0, stride = 1;  // samples
  Eigen::VectorXd mean, first, second;

  Filter(double width, double period) {
    reach = std::max<Eigen::Index>(2, static_cast<Eigen::Index>(std::ceil(4.0 * width / period)));
    stride = 2 * static_cast<Eigen::Index>(width / (8.0 * period)) + 1;  // odd: the samples about a row have a midst
    const Eigen::ArrayXd t = period * Eigen::ArrayXd::LinSpaced(2 * reach + 1, double(-reach), double(reach));
    const Eigen::ArrayXd bell = (-0.5 * (t / width).square()).exp();
    mean = bell / bell.sum();
    first = -(t * bell) / (t.square() * bell).sum();
    Eigen::ArrayXd curved = bell * ((t / width).square() - 1.0);
    curved -= bell * (curved.sum() / bell.sum());
    second = 2.0 * curved / (t.square() * curved).sum();
  }

  /// Rows of what is filtered: `reach` samples are lost at each end, of the others each `stride`-th is one.
  Eigen::Index rows(Eigen::Index samples) const {
    return std::max<Eigen::Index>(0, (samples - 2 * reach + stride - 1) / stride);
  }

  /// Filtered columns.
  Eigen::MatrixXd operator()(const Eigen::VectorXd& weights, const Eigen::MatrixXd& signal) const {
    const Eigen::VectorXd turned = weights.reverse();
    Eigen::MatrixXd result(rows(signal.rows()), signal.cols());
    for (Eigen::Index j = 0; j < result.cols(); ++j) {
      for (Eigen::Index i = 0; i < result.rows(); ++i) {
        result(i, j) = turned.dot(signal.col(j).segment(i * stride, turned.size()));
      }
    }
    return result;
  }

  /// Means of columns over each row's part of the samples.
  Eigen::MatrixXd means(const Eigen::MatrixXd& signal) const {
    const Eigen::Index count = rows(signal.rows()), from = reach - stride / 2;
    Eigen::MatrixXd result = Eigen::MatrixXd::Zero(count, signal.cols());
    for (Eigen::Index i = 0; i < stride; ++i) result += signal(Eigen::seqN(from + i, count, stride), Eigen::all);
    return result / static_cast<double>(stride);
  }
};

struct Resampled {
  double start, period;
  Eigen::MatrixXd position, input;
};

/// Samples of one stretch on a uniform grid, straight lines between them.
Resampled resampled(const Measured& m, const Segment& part, double period) {
  const double from = m.time[part.first], to = m.time[part.last];
  const auto count = static_cast<Eigen::Index>((to - from) / period * (1.0 + 1e-9)) + 1;
  Resampled result{from, period, {count, m.position.cols()}, {count, m.input.cols()}};
  std::size_t k = part.first;
  for (Eigen::Index i = 0; i < count; ++i) {
    const double t = from + period * static_cast<double>(i);
    while (k + 1 < part.last && m.time[k + 1] <= t) ++k;
    const double step = m.time[k + 1] - m.time[k], s = std::clamp((t - m.time[k]) / step, 0.0, 1.0);
    const auto row = static_cast<Eigen::Index>(k);
    result.position.row(i) = (1.0 - s) * m.position.row(row) + s * m.position.row(row + 1);
    result.input.row(i) = (1.0 - s) * m.input.row(row) + s * m.input.row(row + 1);
  }
  if (!m.linear_hold) {  // about a sample half of the period belongs to the input before it
    const Eigen::MatrixXd before = result.input.topRows(count - 1);
    result.input.bottomRows(count - 1) = 0.5 * (result.input.bottomRows(count - 1) + before);
  }
  return result;
}

std::vector<Resampled> all_resampled(const std::vector<Measured>& data) {
  std::vector<Resampled> list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const double period = sample_period(data[r].time);
    for (const Segment& part : stretches(data[r], r)) {
      if (part.samples() >= kFewestInWindow) list.push_back(resampled(data[r], part, period));
    }
  }
  return list;
}

bool long_enough(const Resampled& part, const Filter& filter) { return part.position.rows() > 5 * filter.reach; }

/// Mean square of smoothed accelerations of one joint.
double mean_square_acceleration(const std::vector<Resampled>& parts, double width, Eigen::Index joint) {
  double sum = 0.0, count = 0.0;
  for (const Resampled& part : parts) {
    const Filter filter(width, part.period);
    const Eigen::MatrixXd a = filter(filter.second, part.position.col(joint));
    sum += a.squaredNorm();
    count += static_cast<double>(a.rows());
  }
  return count > 0.0 ? sum / count : 0.0;
}

double choose_width(const std::vector<Measured>& data, const std::vector<Resampled>& parts) {
  const Eigen::VectorXd noise = noise_level(data);
  const double period = shortest_sample_period(data);
  const double frequency = std::max(mean_frequency(data, noise), 1e-9);
  double longest = 0.0;  // s, of a stretch
  for (const Resampled& part : parts)
    longest = std::max(longest, part.period * static_cast<double>(part.position.rows()));
  const double slow = std::min(1.0 / (4.0 * std::numbers::pi * frequency), kSettings.doubt.widest * longest);
  const double widest = std::max(2.0 * period, slow);
  double width = 2.0 * period;
  for (; width < widest; width *= std::numbers::sqrt2) {
    bool clear = true;
    for (Eigen::Index j = 0; j < noise.size(); ++j) {
      const double from_noise =
          noise[j] * noise[j] * period * 0.375 / (std::sqrt(std::numbers::pi) * std::pow(width, 5.0));
      clear &= from_noise < kSettings.doubt.noise_share * mean_square_acceleration(parts, width, j);
    }
    if (clear) break;
  }
  return std::min(width, widest);
}

/// Least squares in which some coefficients must not be positive: those that are become zero.
double least_squares_left(Eigen::MatrixXd columns, const Eigen::VectorXd& target, std::vector<bool> signed_) {
  while (columns.cols() > 0) {
    const Eigen::VectorXd x = PivotedQr(columns).solve(target);
    Eigen::Index worst = -1;
    double most = 0.0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double size = x[i] * columns.col(i).norm();
      if (!signed_[static_cast<std::size_t>(i)] || size <= most) continue;
      most = size;
      worst = i;
    }
    if (worst < 0) return (target - columns * x).squaredNorm();
    const Eigen::Index rest = columns.cols() - 1 - worst;
    columns.middleCols(worst, rest) = columns.rightCols(rest).eval();
    columns.conservativeResize(Eigen::NoChange, columns.cols() - 1);
    signed_.erase(signed_.begin() + worst);
  }
  return target.squaredNorm();
}

}  // namespace

Kinematics observe(const std::vector<Measured>& data) {
  const std::vector<Resampled> parts = all_resampled(data);
  Kinematics result;
  if (parts.empty()) return result;
  result.width = choose_width(data, parts);
  for (const Resampled& part : parts) {
    const Filter filter(result.width, part.period);
    if (!long_enough(part, filter)) continue;
    result.stretches.push_back({part.start + part.period * static_cast<double>(filter.reach),
                                part.period * static_cast<double>(filter.stride), filter(filter.mean, part.position),
                                filter(filter.first, part.position), filter(filter.second, part.position),
                                filter.means(part.input)});
  }
  return result;
}

Kinematics Observer::operator()(const std::vector<Measured>& changed) const {
  const auto same = [&](auto&& equal) { return std::ranges::equal(data_, changed, equal); };
  const auto same_motion = [](const Measured& a, const Measured& b) {
    return a.time == b.time && a.position == b.position;
  };
  if (!same(same_motion)) return observe(changed);
  if (same([](const Measured& a, const Measured& b) { return a.input == b.input; })) return seen_;
  Kinematics result = seen_;
  auto stretch = result.stretches.begin();
  for (const Resampled& part : all_resampled(changed)) {
    const Filter filter(seen_.width, part.period);
    if (long_enough(part, filter)) (stretch++)->input = filter.means(part.input);
  }
  return result;
}

namespace {

constexpr Eigen::Index kFrictions = 3;  // in each joint: constant, viscous, dry

/// RMS of accelerations and speeds of each joint.
struct Sizes {
  Eigen::VectorXd acceleration, speed;

  explicit Sizes(const Kinematics& seen) {
    const Eigen::Index joints = seen.stretches.front().position.cols();
    acceleration = speed = Eigen::VectorXd::Zero(joints);
    double count = 0.0;
    for (const Kinematics::Stretch& s : seen.stretches) {
      acceleration += s.acceleration.colwise().squaredNorm().transpose();
      speed += s.velocity.colwise().squaredNorm().transpose();
      count += static_cast<double>(s.velocity.rows());
    }
    acceleration = (acceleration / count).cwiseSqrt();
    speed = (speed / count).cwiseSqrt();
  }
};

/// Numbers that accelerate joints, smoothed as accelerations are and in units of their RMS, joint below joint: a column
/// for each `width` numbers of `raw`'s rows, in which joints stand beside each other.
Eigen::MatrixXd stacked(const Eigen::MatrixXd& raw, const Filter& filter, const Eigen::VectorXd& rms) {
  const Eigen::MatrixXd smooth = filter(filter.mean, raw);
  const Eigen::Index joints = rms.size(), width = raw.cols() / joints, rows = smooth.rows();
  Eigen::MatrixXd result(rows * joints, width);
  for (Eigen::Index i = 0; i < joints; ++i) {
    result.middleRows(i * rows, rows) = smooth.middleCols(i * width, width) / rms[i];
  }
  return result;
}

/// What is measured, and what a plant and friction would add to it.
struct Rows {
  Eigen::MatrixXd frictions;  // samples and joints x kFrictions of each joint
  Eigen::VectorXd left;       // measured less that of the plant
  bool finite = true;
};

Rows rows_of(const Plant& plant, const Kinematics& seen, const Sizes& sizes, bool with_input) {
  const Eigen::Index joints = sizes.speed.size(), columns = kFrictions * joints;
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index rows = 0;
  for (const Kinematics::Stretch& s : seen.stretches) {
    const Eigen::Index samples = s.position.rows();
    Eigen::MatrixXd raw(samples, joints * (columns + 1));
    for (Eigen::Index k = 0; k < samples; ++k) {
      const JointVector q = s.position.row(k), v = s.velocity.row(k);
      const JointVector u = with_input ? JointVector(s.input.row(k)) : JointVector(JointVector::Zero(joints));
      const Motion now = motion(plant, q, v, u, s.start + s.period * static_cast<double>(k));
      for (Eigen::Index i = 0; i < joints; ++i) {
        const Eigen::Index at = i * (columns + 1);
        for (Eigen::Index j = 0; j < joints; ++j) {
          const double moved = now.mobility(i, j);
          raw(k, at + kFrictions * j) = moved;
          raw(k, at + kFrictions * j + 1) = moved * v[j];
          raw(k, at + kFrictions * j + 2) = moved * std::tanh(v[j] / (kSettings.doubt.slow * sizes.speed[j] + 1e-300));
        }
        raw(k, at + columns) = now.acceleration[i];
      }
    }
    if (!raw.allFinite()) return {{}, {}, false};
    const Filter filter(seen.width, s.period);
    Eigen::MatrixXd part = stacked(raw, filter, sizes.acceleration);
    const Eigen::MatrixXd measured = s.acceleration.middleRows(filter.reach, part.rows() / joints);
    for (Eigen::Index i = 0; i < joints; ++i) {
      auto block = part.col(columns).segment(i * measured.rows(), measured.rows());
      block = measured.col(i) / sizes.acceleration[i] - block.eval();
    }
    rows += part.rows();
    parts.push_back(std::move(part));
  }
  Rows result{{rows, columns}, Eigen::VectorXd(rows)};
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& part : parts) {
    result.frictions.middleRows(at, part.rows()) = part.leftCols(columns);
    result.left.segment(at, part.rows()) = part.col(columns);
    at += part.rows();
  }
  return result;
}

bool has_motion(const Kinematics& seen) { return !seen.stretches.empty() && Sizes(seen).acceleration.minCoeff() > 0.0; }

/// What the inputs of all joints add at some lags. `turned`: by how much of a stretch they are moved, going round;
/// negative: backwards in time as well.
Eigen::MatrixXd lagged(const Plant& plant, const Kinematics& seen, const Sizes& sizes, double turned) {
  constexpr int kLags = 11;
  constexpr double kLongest = 0.5;  // s
  const Eigen::Index joints = sizes.speed.size();
  std::vector<Eigen::MatrixXd> parts;
  Eigen::Index rows = 0;
  for (const Kinematics::Stretch& s : seen.stretches) {
    const Eigen::Index samples = s.position.rows();
    const auto shift = static_cast<Eigen::Index>(std::abs(turned) * static_cast<double>(samples));
    Eigen::MatrixXd raw(samples, joints * joints * kLags);
    for (Eigen::Index k = 0; k < samples; ++k) {
      const JointVector q = s.position.row(k), v = s.velocity.row(k);
      const JointMatrix mobility =
          motion(plant, q, v, JointVector::Zero(joints), s.start + s.period * static_cast<double>(k)).mobility;
      for (int lag = 0; lag < kLags; ++lag) {
        const auto late = static_cast<Eigen::Index>(std::round(kLongest * lag / (kLags - 1) / s.period));
        Eigen::Index from = std::max<Eigen::Index>(0, k - late);
        if (turned != 0.0) from = ((turned < 0.0 ? samples - 1 - k : k) + late + shift) % samples;
        for (Eigen::Index i = 0; i < joints; ++i) {
          for (Eigen::Index j = 0; j < joints; ++j) {
            raw(k, (i * joints + j) * kLags + lag) = mobility(i, j) * s.input(from, j);
          }
        }
      }
    }
    parts.push_back(stacked(raw, Filter(seen.width, s.period), sizes.acceleration));
    rows += parts.back().rows();
  }
  Eigen::MatrixXd all(rows, parts.front().cols());
  Eigen::Index at = 0;
  for (const Eigen::MatrixXd& part : parts) {
    all.middleRows(at, part.rows()) = part;
    at += part.rows();
  }
  return all;
}

}  // namespace

double unexplained(const Plant& plant, const Kinematics& seen) {
  if (!has_motion(seen)) return kInfinity;
  const Rows rows = rows_of(plant, seen, Sizes(seen), true);
  if (!rows.finite) return kInfinity;
  std::vector<bool> drags;
  for (Eigen::Index i = 0; i < rows.frictions.cols(); ++i) drags.push_back(i % kFrictions != 0);
  return least_squares_left(rows.frictions, rows.left, drags) / static_cast<double>(rows.left.size());
}

bool Answer::none() const {
  return input_share > kSettings.doubt.matters && explained < kSettings.doubt.some_answer && explained <= by_chance;
}

Answer answer_to_input(const Plant& plant, const Kinematics& seen) {
  Answer result;
  if (!has_motion(seen)) return result;
  const Sizes sizes(seen);
  const Rows alone = rows_of(plant, seen, sizes, false), driven = rows_of(plant, seen, sizes, true);
  if (!alone.finite || !driven.finite) return result;
  result.input_share = (driven.left - alone.left).squaredNorm() / static_cast<double>(alone.left.size());
  if (result.input_share == 0.0) return result;
  const Eigen::MatrixXd basis = PivotedQr(alone.frictions).basis();
  const auto without_friction = [&](const Eigen::MatrixXd& x) { return (x - basis * (basis.transpose() * x)).eval(); };
  const Eigen::VectorXd target = without_friction(alone.left);
  const auto explained = [&](double turned) {
    const Eigen::MatrixXd columns = without_friction(lagged(plant, seen, sizes, turned));
    return 1.0 - (target - columns * PivotedQr(columns).solve(target)).squaredNorm() / target.squaredNorm();
  };
  result.explained = explained(0.0);
  for (const double turned : {0.3, 0.4, 0.5, 0.6, 0.7}) {
    result.by_chance = std::max({result.by_chance, explained(turned), explained(-turned)});
  }
  return result;
}

}  // namespace bayesctrl
