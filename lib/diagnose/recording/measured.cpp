#include "diagnose/recording/measured.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/fields.hpp"
#include "base/format.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Divided difference of sixth order over seven samples from k on, scaled so that white noise keeps its standard
/// deviation. It vanishes for polynomials of fifth degree whatever the time stamps are.
double sixth_difference(const std::vector<double>& t, const Eigen::VectorXd& q, std::size_t k) {
  double sum = 0.0, squares = 0.0;
  const double unit = (t[k + 6] - t[k]) / 6.0;
  for (std::size_t i = 0; i < 7; ++i) {
    double weight = 1.0;
    for (std::size_t j = 0; j < 7; ++j) {
      if (j != i) weight *= unit / (t[k + i] - t[k + j]);
    }
    sum += weight * q[static_cast<Eigen::Index>(k + i)];
    squares += weight * weight;
  }
  return sum / std::sqrt(squares);
}

}  // namespace

double samples(const std::vector<Measured>& data) {
  double sum = 0.0;
  for (const Measured& m : data) sum += static_cast<double>(m.samples());
  return sum;
}

double sample_period(const std::vector<double>& time) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < time.size(); ++k) steps.push_back(time[k] - time[k - 1]);
  return median(std::move(steps));
}

double shortest_sample_period(const std::vector<Measured>& data) {
  double shortest = kInfinity;
  for (const Measured& m : data) shortest = std::min(shortest, sample_period(m.time));
  return shortest;
}

std::vector<Segment> stretches(const Measured& measured, std::size_t recording) {
  std::vector<Segment> list;
  const std::vector<double>& t = measured.time;
  if (t.empty()) return list;
  const double gap = kSettings.recording.gap_periods * sample_period(t);
  std::size_t first = 0;
  for (std::size_t k = 1; k <= t.size(); ++k) {
    if (k < t.size() && t[k] - t[k - 1] <= gap) continue;
    list.push_back({recording, first, k - 1, true});
    first = k;
  }
  return list;
}

Restarts restarts_of(const Measured& measured) {
  Restarts list;
  for (const Segment& stretch : stretches(measured, 0)) list.push_back({stretch.first, {}});
  return list;
}

std::string no_window(const std::vector<Measured>& data, double length) {
  if (!windows(data, length).empty()) return "";
  double longest = 0.0, shortest = kInfinity;
  for (std::size_t r = 0; r < data.size(); ++r) {
    shortest = std::min(shortest, kFewestInWindow * sample_period(data[r].time));
    for (const Segment& stretch : stretches(data[r], r)) {
      longest = std::max(longest, data[r].time[stretch.last] - data[r].time[stretch.first]);
    }
  }
  return format(length, 4) + " s: recordings without a gap hold windows of " + format(shortest, 3) + " to " +
         format(longest, 4) + " s";
}

std::vector<Segment> windows(const std::vector<Measured>& data, double length, std::size_t least) {
  std::vector<Segment> list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const std::vector<double>& t = data[r].time;
    const double period = sample_period(t);
    for (const Segment& stretch : stretches(data[r], r)) {
      std::size_t first = stretch.first;
      while (first < stretch.last) {
        std::size_t last = first;
        const double end = t[first] + length * (1.0 + 1e-9) - 0.5 * period;
        while (last + 1 <= stretch.last && t[last + 1] <= end) ++last;
        const bool whole = last < stretch.last || t[last] - t[first] > 0.5 * length;
        if (whole && last - first + 1 >= least) list.push_back({r, first, last, first == stretch.first});
        first = last + 1;
      }
    }
  }
  return list;
}

double mean_frequency(const std::vector<Measured>& data, const Eigen::VectorXd& noise) {
  double highest = 0.0;
  for (Eigen::Index j = 0; j < noise.size(); ++j) {
    double speed = 0.0, position = 0.0;
    for (const Measured& m : data) {
      const Eigen::VectorXd q = m.position.col(j);
      const double h = sample_period(m.time), mean = q.mean();
      const Eigen::Index n = q.size() - 1;
      const double steps = (q.tail(n) - q.head(n)).squaredNorm() - 2.0 * noise[j] * noise[j] * static_cast<double>(n);
      speed += std::max(0.0, steps) / (h * h);
      position += (q.array() - mean).square().sum();
    }
    if (position > 0.0) highest = std::max(highest, std::sqrt(speed / position) / (2.0 * std::numbers::pi));
  }
  return highest;
}

double recorded_seconds(const std::vector<Measured>& data) {
  double sum = 0.0;
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (const Segment& stretch : stretches(data[r], r))
      sum += data[r].time[stretch.last] - data[r].time[stretch.first];
  }
  return sum;
}

std::vector<Measured> excerpts(const std::vector<Measured>& data, double seconds, double length) {
  const double all = recorded_seconds(data);
  if (all <= seconds) return data;
  constexpr double kShortest = 4.0;  // s, where there are many recordings
  length = std::min(length, std::max(kShortest, seconds / static_cast<double>(data.size())));
  const double every = all * std::min(1.0, length / seconds);  // seconds from the beginning of one to that of the next
  std::vector<Measured> result;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const Measured& m = data[r];
    double passed = 0.0;  // gaps left out
    std::vector<Eigen::Index> kept;
    for (const Segment& stretch : stretches(m, r)) {
      for (std::size_t k = stretch.first; k <= stretch.last; ++k) {
        const bool within = std::fmod(passed + m.time[k] - m.time[stretch.first], every) <= length;
        if (within || k == 0 || k + 1 == m.samples()) kept.push_back(static_cast<Eigen::Index>(k));
      }
      passed += m.time[stretch.last] - m.time[stretch.first];
    }
    Measured& less = result.emplace_back(m.emptied());
    for (const Eigen::Index k : kept) less.time.push_back(m.time[static_cast<std::size_t>(k)]);
    less.position = m.position(kept, Eigen::all);
    less.input = m.input(kept, Eigen::all);
  }
  return result;
}

double quantum(const Eigen::VectorXd& values) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  const double range = sorted.empty() ? 0.0 : sorted.back() - sorted.front();
  std::vector<double> steps;
  for (std::size_t k = 1; k < sorted.size(); ++k) {
    if (sorted[k] - sorted[k - 1] > 1e-9 * range) steps.push_back(sorted[k] - sorted[k - 1]);
  }
  // Quantised values repeat: few different ones, and the steps between them are multiples of the smallest.
  if (steps.empty() || 2 * steps.size() > sorted.size()) return 0.0;
  const double smallest = *std::min_element(steps.begin(), steps.end());
  for (const double step : steps) {
    const double multiple = step / smallest;
    if (std::abs(multiple - std::round(multiple)) > 0.05 * multiple) return 0.0;
  }
  return smallest;
}

Eigen::VectorXd noise_level(const std::vector<Measured>& data) {
  const Eigen::Index joints = data.front().position.cols();
  Eigen::VectorXd level(joints);
  for (Eigen::Index j = 0; j < joints; ++j) {
    std::vector<double> differences;
    double coarsest = 0.0;
    for (std::size_t r = 0; r < data.size(); ++r) {
      const Eigen::VectorXd q = data[r].position.col(j);
      coarsest = std::max(coarsest, quantum(q));
      for (const Segment& stretch : stretches(data[r], r)) {
        for (std::size_t k = stretch.first; k + 6 <= stretch.last; ++k) {
          differences.push_back(std::abs(sixth_difference(data[r].time, q, k)));
        }
      }
    }
    level[j] = std::max(1.4826 * median(std::move(differences)), coarsest / std::sqrt(12.0));
  }
  return level;
}

}  // namespace bayesctrl
