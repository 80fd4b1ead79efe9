#include "diagnose/motion/decimate.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "diagnose/motion/smoother.hpp"
#include "diagnose/settings.hpp"
#include "numerics/dense.hpp"

namespace bayesctrl {

namespace {

constexpr double kBeyond = 1e-3;  // of an input's range: smooth ones have their peaks between samples, steps do not

/// What the inputs between two samples that stay are replaced by.
enum class Keep { mean, moment };

/// One stretch without a gap: samples that stay, and the input from each to the next, the sum of what was recorded.
struct Thin {
  std::vector<std::size_t> kept;
  Eigen::MatrixXd input;
  FineInput fine;
};

/// Duration for which an input is held; the last one of a stretch for as long as the one before.
double held(const Measured& m, const Segment& stretch, std::size_t i) {
  const std::size_t k = i < stretch.last || i == stretch.first ? i : i - 1;
  return k + 1 < m.samples() ? m.time[k + 1] - m.time[k] : 0.0;
}

/// What samples that stay hold, samples x joints.
Eigen::MatrixXd held(const FineInput& fine, Eigen::Index samples) {
  Eigen::MatrixXd input(samples, fine.input.cols());
  for (Eigen::Index j = 0; j < input.cols(); ++j) input.col(j) = fine.held(fine.input.col(j), samples);
  return input;
}

/// Inputs of one interval, each with the duration for which it is held.
struct Interval {
  std::vector<double> lasts;
  double span = 0.0;

  Interval(const Measured& m, const Segment& stretch, std::size_t first, std::size_t end) {
    for (std::size_t k = first; k < end; ++k) lasts.push_back(held(m, stretch, k));
    span = std::accumulate(lasts.begin(), lasts.end(), 0.0);
    if (span > 0.0) return;
    lasts.assign(lasts.size(), 1.0);  // the last sample of a recording, alone
    span = static_cast<double>(lasts.size());
  }
};

/// Adds an interval that sample `stays` holds; `next`: the one that gets part of what comes late in it, if any does.
void add(FineInput& fine, Eigen::Index stays, const Interval& interval, const Interval* next) {
  double passed = 0.0;
  for (const double h : interval.lasts) {
    const double handed = next == nullptr ? 0.0 : h * (passed + 0.5 * h - 0.5 * interval.span) / interval.span;
    fine.stays.push_back(stays);
    fine.own.push_back((h - handed) / interval.span);
    fine.late.push_back(next == nullptr ? 0.0 : handed / next->span);
    passed += h;
  }
}

/// The impulse of each interval is kept and, with Keep::moment, its time: of what came later than the middle of an
/// interval part is handed to the next. Nothing where that would leave the range of the inputs around
/// by more than kBeyond.
std::optional<Thin> thin_stretch(const Measured& m, const Segment& stretch, std::size_t factor, Keep keep) {
  Thin thin;
  for (std::size_t k = stretch.first; k <= stretch.last; k += factor) thin.kept.push_back(k);
  const auto count = static_cast<Eigen::Index>(thin.kept.size());
  if (m.linear_hold) {  // what lies between is a straight line
    thin.input.resize(count, m.input.cols());
    for (Eigen::Index i = 0; i < count; ++i) {
      thin.input.row(i) = m.input.row(static_cast<Eigen::Index>(thin.kept[static_cast<std::size_t>(i)]));
    }
    return thin;
  }
  thin.fine.input = m.input.middleRows(static_cast<Eigen::Index>(stretch.first),
                                       static_cast<Eigen::Index>(stretch.last - stretch.first) + 1);
  const auto end_of = [&](std::size_t first) { return std::min(first + factor, stretch.last + 1); };
  std::vector<Interval> intervals;
  for (const std::size_t first : thin.kept) intervals.emplace_back(m, stretch, first, end_of(first));
  for (Eigen::Index i = 0; i < count; ++i) {
    const bool hands = keep == Keep::moment && i + 1 < count;
    const auto at = intervals.begin() + i;
    add(thin.fine, i, *at, hands ? &*(at + 1) : nullptr);
  }
  thin.input = held(thin.fine, count);
  if (keep == Keep::mean) return thin;
  const Eigen::RowVectorXd slack = kBeyond * (m.input.colwise().maxCoeff() - m.input.colwise().minCoeff());
  for (Eigen::Index i = 0; i < count; ++i) {
    const std::size_t first = thin.kept[static_cast<std::size_t>(i)];
    const std::size_t before = first - stretch.first >= factor ? first - factor : stretch.first;
    const std::size_t after = std::min(end_of(first) + factor, stretch.last + 1);
    const auto around =
        m.input.middleRows(static_cast<Eigen::Index>(before), static_cast<Eigen::Index>(after - before));
    if (((thin.input.row(i) - around.colwise().minCoeff() + slack).array() < 0.0).any() ||
        ((around.colwise().maxCoeff() - thin.input.row(i) + slack).array() < 0.0).any()) {
      return std::nullopt;
    }
  }
  return thin;
}

/// A recording that holds one stretch, thinned out.
Measured recording_of(const Measured& m, const Thin& thin) {
  Measured less = m.emptied();
  less.input = thin.input;
  less.position.resize(thin.input.rows(), m.position.cols());
  for (std::size_t i = 0; i < thin.kept.size(); ++i) {
    less.time.push_back(m.time[thin.kept[i]]);
    less.position.row(static_cast<Eigen::Index>(i)) = m.position.row(static_cast<Eigen::Index>(thin.kept[i]));
  }
  return less;
}

/// Positions of the nominal, in units of the noise, at samples first + 1 to last of a recording: every one of them, or
/// at `kept` ones. Shorter where it diverges.
Eigen::MatrixXd simulated(const Plant& nominal, const Measured& m, const std::vector<std::size_t>& kept,
                          std::size_t first, std::size_t last, const Eigen::VectorXd& start,
                          const Eigen::VectorXd& noise) {
  const Eigen::Index n = noise.size();
  JointVector q = start.head(n), v = start.tail(n);
  Eigen::MatrixXd positions(static_cast<Eigen::Index>(last - first), n);
  for (std::size_t i = first; i < last; ++i) {
    const std::size_t from = kept.empty() ? i : kept[i], to = kept.empty() ? i + 1 : kept[i + 1];
    for (std::size_t k = from; k < to; ++k) propagate(nominal, q, v, m, k, JointVector::Zero(n));
    if (!q.allFinite()) return positions.topRows(static_cast<Eigen::Index>(i - first));
    positions.row(static_cast<Eigen::Index>(i - first)) = q.cwiseQuotient(JointVector(noise)).transpose();
  }
  return positions;
}

/// Sums of squares over windows, in units of the noise, less what other starts of the windows do.
struct Shown {
  double moved = 0.0;  // of simulations of the nominal, by the thinned inputs
  double left = 0.0;   // of what these lack of the measured positions, beyond the noise

  void operator+=(const Shown& more) {
    moved += more.moved;
    left += more.left;
  }
};

/// Simulations of one window about a start.
struct About {
  Eigen::MatrixXd positions;  // samples x joints
  Eigen::MatrixXd by_start;   // (samples * joints) x states, per unit of each

  Eigen::Index rows() const { return positions.rows(); }

  /// Of the first rows alone.
  About until(Eigen::Index count) const {
    const Eigen::Index n = positions.cols();
    About part{positions.topRows(count), Eigen::MatrixXd(count * n, by_start.cols())};
    for (Eigen::Index j = 0; j < n; ++j) {
      part.by_start.middleRows(j * count, count) = by_start.middleRows(j * rows(), count);
    }
    return part;
  }

  /// Change of the start that explains `apart` best.
  Eigen::VectorXd change(const Eigen::VectorXd& apart) const {
    const Eigen::VectorXd size = by_start.colwise().norm();
    const Eigen::MatrixXd scaled = by_start * size.cwiseInverse().asDiagonal();
    return solve_symmetric(scaled.transpose() * scaled, scaled.transpose() * apart).reshaped().cwiseQuotient(size);
  }
};

About about(const Eigen::VectorXd& start, auto&& run) {
  constexpr double kChange = 1e-5;  // rad or m, and per second
  const Eigen::Index states = start.size(), n = states / 2;
  About result{run(start), {}};
  std::vector<Eigen::MatrixXd> others;
  Eigen::Index rows = result.positions.rows();
  for (Eigen::Index c = 0; c < states; ++c) {
    Eigen::VectorXd other = start;
    other[c] += kChange;
    others.push_back(run(other));
    rows = std::min(rows, others.back().rows());
  }
  result.positions.conservativeResize(rows, n);
  result.by_start.resize(rows * n, states);
  for (Eigen::Index c = 0; c < states; ++c) {
    result.by_start.col(c) =
        (others[static_cast<std::size_t>(c)].topRows(rows) - result.positions).reshaped() / kChange;
  }
  return result;
}

Shown shown_in(const Plant& nominal, const Measured& m, const Measured& less, const Thin& thin,
               const Eigen::VectorXd& noise, std::size_t first, std::size_t last) {
  const Eigen::Index n = noise.size();
  const Eigen::MatrixXd measured =
      less.position.middleRows(static_cast<Eigen::Index>(first) + 1, static_cast<Eigen::Index>(last - first)) *
      noise.cwiseInverse().asDiagonal();
  const std::size_t ahead = std::min(first + 4, last);
  const auto at = [&](std::size_t i) { return less.position.row(static_cast<Eigen::Index>(i)).transpose(); };
  Eigen::VectorXd start(2 * n);
  start << at(first), (at(ahead) - at(first)) / (less.time[ahead] - less.time[first]);
  const auto run = [&](const Eigen::VectorXd& x) { return simulated(nominal, less, {}, first, last, x, noise); };
  About coarse = about(start, run);
  for (const Eigen::Index part :
       {8, 4, 2, 1, 1}) {  // more and more of the window: far from its start it may be chaotic
    const Eigen::Index rows = coarse.rows() / part;
    if (rows < 4) continue;
    start += coarse.until(rows).change((measured.topRows(rows) - coarse.positions.topRows(rows)).reshaped());
    coarse = about(start, run);
  }
  const Eigen::MatrixXd fine = simulated(nominal, m, thin.kept, first, last, start, noise);
  if (coarse.rows() <= 2 || fine.rows() < coarse.rows()) return {};
  const auto squares = [&](const Eigen::MatrixXd& apart) {
    const Eigen::VectorXd flat = apart.reshaped();
    return (flat - coarse.by_start * coarse.change(flat)).squaredNorm();
  };
  return {
      squares(fine.topRows(coarse.rows()) - coarse.positions),
      squares(measured.topRows(coarse.rows()) - fine.topRows(coarse.rows())) - static_cast<double>(n * coarse.rows())};
}

/// The same over windows of `length` seconds.
Shown shown_by(const Plant& nominal, const Measured& m, const Measured& less, const Thin& thin,
               const Eigen::VectorXd& noise, double length) {
  Shown sum;
  for (std::size_t first = 0; first + kFewestInWindow < thin.kept.size();) {
    std::size_t last = first;
    while (last + 1 < thin.kept.size() && less.time[last] - less.time[first] < length) ++last;
    sum += shown_in(nominal, m, less, thin, noise, first, last);
    first = last;
  }
  return sum;
}

void append(Eigen::MatrixXd& rows, const Eigen::MatrixXd& more) {
  rows.conservativeResize(rows.rows() + more.rows(), more.cols());
  rows.bottomRows(more.rows()) = more;
}

void append(FineInput& all, const FineInput& part, Eigen::Index before) {
  append(all.input, part.input);
  for (const Eigen::Index sample : part.stays) all.stays.push_back(before + sample);
  all.own.insert(all.own.end(), part.own.begin(), part.own.end());
  all.late.insert(all.late.end(), part.late.begin(), part.late.end());
}

void append(Measured& all, const Measured& part) {
  all.time.insert(all.time.end(), part.time.begin(), part.time.end());
  append(all.position, part.position);
  append(all.input, part.input);
}

/// The whole recording by one factor, and how much that shows.
struct Thinned {
  Measured data;
  double moved = 0.0;  // squares, in units of the noise
  double lacks = 0.0;  // what is significant of what the nominal leaves
};

std::optional<Thinned> thinned_by(const Plant& nominal, const Measured& m, std::size_t r, std::size_t factor, Keep keep,
                                  const Eigen::VectorXd& noise) {
  Measured all = m.emptied();
  FineInput fine;
  Shown sum;
  double samples = 0.0;
  for (const Segment& stretch : stretches(m, r)) {
    const std::optional<Thin> thin = thin_stretch(m, stretch, factor, keep);
    if (!thin) return std::nullopt;
    const Measured less = recording_of(m, *thin);
    sum += shown_by(nominal, m, less, *thin, noise, kSettings.motion.segment);
    samples += static_cast<double>(less.position.size());
    if (!m.linear_hold) append(fine, thin->fine, all.position.rows());
    append(all, less);
  }
  if (!m.linear_hold) all.fine = std::make_shared<const FineInput>(std::move(fine));
  return Thinned{std::move(all), sum.moved, sum.left - 5.0 * std::sqrt(2.0 * samples)};
}

/// What does not show beside the noise comes first, then what does not beside what the nominal lacks.
Measured thinned(const Plant& nominal, const Measured& m, std::size_t r, std::size_t most,
                 const Eigen::VectorXd& noise) {
  std::optional<Thinned> second;
  for (std::size_t factor = most; factor > 1; factor /= 2) {
    std::optional<Thinned> lax;  // that moves least by this factor
    for (const Keep keep : {Keep::mean, Keep::moment}) {
      std::optional<Thinned> found = thinned_by(nominal, m, r, factor, keep, noise);
      if (!found) continue;
      if (found->moved < kSettings.motion.thinning) return std::move(found->data);
      const bool suffices = found->moved < kSettings.motion.thinning_share * found->lacks;
      if (suffices && (!lax || found->moved < lax->moved)) lax = std::move(found);
    }
    if (!second) second = std::move(lax);
  }
  return second ? std::move(second->data) : m;
}

}  // namespace

std::vector<Measured> decimated(const Plant& nominal, const std::vector<Measured>& data, const Eigen::VectorXd& noise,
                                double rate) {
  std::vector<Measured> result;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const auto factor = static_cast<std::size_t>(1.0 / (sample_period(data[r].time) * rate) + 1e-6);
    result.push_back(factor < 2 ? data[r] : thinned(nominal, data[r], r, factor, noise));
  }
  return result;
}

}  // namespace bayesctrl
