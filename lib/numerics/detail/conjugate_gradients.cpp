#include "numerics/detail/conjugate_gradients.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bayesctrl {

namespace {

constexpr double kMargin = 0.1;        // of the bracket, that a new step keeps from its ends
constexpr double kExpansion = 3.0;     // of the last step, at most
constexpr double kMostOfSlope = 0.1;   // of the first slope, that an accepted step may leave
constexpr double kLeastOfFall = 0.05;  // of what the first slope promises, that a step must bring
constexpr double kMostGrowth = 10.0;   // of the first step, from one line to the next
constexpr int kMostOnALine = 20;       // evaluations

/// What was found at one step along a line.
struct Point {
  double step = 0.0, value = 0.0, slope = 0.0;
};

/// Where the cubic through two points is least, beyond the second.
double cubic_beyond(const Point& a, const Point& b) {
  const double d = b.step - a.step;
  const double p = 6.0 * (a.value - b.value) + 3.0 * (b.slope + a.slope) * d;
  const double q = 3.0 * (b.value - a.value) - (2.0 * a.slope + b.slope) * d;
  return a.step - a.slope * d * d / (q + std::sqrt(q * q - p * a.slope * d));
}

/// Where the quadratic (if b lies above the line's beginning) or the cubic is least, between the two.
double least_between(const Point& a, const Point& b, double begin) {
  const double d = b.step - a.step;
  if (b.value > begin) return a.step - 0.5 * a.slope * d * d / (b.value - a.value - a.slope * d);
  const double p = 6.0 * (a.value - b.value) / d + 3.0 * (b.slope + a.slope);
  const double q = 3.0 * (b.value - a.value) - (2.0 * a.slope + b.slope) * d;
  return a.step + (std::sqrt(q * q - p * a.slope * d * d) - q) / p;
}

class Search {
 public:
  Search(const Objective& objective, const Eigen::VectorXd& start, const Eigen::VectorXd& low,
         const Eigen::VectorXd& high, const MinimizeOptions& options)
      : objective_(objective), low_(low), high_(high), options_(options), x_(start), gradient_(start.size()) {
    best_.value = std::numeric_limits<double>::infinity();
    best_.x = start;
    value_ = evaluate(x_, gradient_);
  }

  MinimizeSummary run() {
    if (!std::isfinite(value_)) return best_;
    bool failed = false;  // the line before was left without a step that is good enough
    double first = restart();
    while (best_.evaluations < options_.max_evaluations) {
      if (slope_ == 0.0) {
        best_.converged = true;
        break;
      }
      const double before = value_;
      const Eigen::VectorXd old = gradient_;
      const Point end = follow(first);
      if (good(end) && std::abs(end.slope) <= -kMostOfSlope * slope_) {
        x_ = (x_ + end.step * direction_).cwiseMax(low_).cwiseMin(high_);
        value_ = end.value;
        gradient_ = seen_;
        direction_ = (gradient_.squaredNorm() - old.dot(gradient_)) / old.squaredNorm() * direction_ - gradient_;
        const double last = slope_;
        slope_ = gradient_.dot(direction_);
        if (slope_ > 0.0) restart();
        first = end.step * std::min(kMostGrowth, last / (slope_ - std::numeric_limits<double>::min()));
        failed = false;
        if (std::abs(before - value_) <= options_.relative_tolerance * std::abs(value_)) {
          best_.converged = true;
          break;
        }
      } else {
        x_ = best_.x;
        value_ = best_.value;
        gradient_ = best_gradient_;
        if (failed) break;
        first = restart();
        failed = true;
      }
    }
    return best_;
  }

 private:
  /// Beyond a bound the objective is what it is on it; there, nothing leads further out.
  double evaluate(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
    const Eigen::VectorXd inside = x.cwiseMax(low_).cwiseMin(high_);
    const double value = objective_(inside, gradient);
    ++best_.evaluations;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const bool outwards = (inside[i] <= low_[i] && gradient[i] > 0.0) || (inside[i] >= high_[i] && gradient[i] < 0.0);
      if (x[i] != inside[i] || outwards) gradient[i] = 0.0;
    }
    if (std::isfinite(value) && gradient.allFinite() && value < best_.value) {
      best_.value = value;
      best_.x = inside;
      best_gradient_ = gradient;
    }
    return value;
  }

  Point at(double step) {
    const double value = evaluate(x_ + step * direction_, seen_);
    return {step, value, seen_.dot(direction_)};
  }

  static bool finite(const Point& p) { return std::isfinite(p.value) && std::isfinite(p.slope); }
  bool good(const Point& p) const { return finite(p) && p.value <= value_ + p.step * kLeastOfFall * slope_; }

  /// Takes the direction of steepest descent, and returns a first step along it.
  double restart() {
    direction_ = -gradient_;
    slope_ = -direction_.squaredNorm();
    return 1.0 / (1.0 - slope_);
  }

  /// One line, from a first step: out until it rises or flattens, each time by the cubic through its beginning; then in
  /// between.
  Point follow(double first) {
    const Point begin{0.0, value_, slope_};
    int left = std::min(kMostOnALine, options_.max_evaluations - best_.evaluations);
    Point near = begin, far;
    double step = first;
    while (true) {
      for (far = at(step), --left; !finite(far) && left > 0; --left) {
        step = 0.5 * (near.step + step);
        far = at(step);
      }
      if (!finite(far) || far.slope > kMostOfSlope * slope_ || !good(far) || left <= 0) break;
      const double next = cubic_beyond(begin, far), most = kExpansion * far.step;
      const double least = (1.0 + kMargin) * far.step;
      step = std::isfinite(next) && next >= 0.0 ? std::clamp(next, least, most) : most;
    }
    Point end = far, high = far;
    while (left > 0 && (!good(end) || std::abs(end.slope) > -kMostOfSlope * slope_)) {
      if (end.slope > 0.0 || !good(end)) {
        high = end;
      } else {
        near = end;
      }
      const double width = high.step - near.step, least = least_between(near, high, value_);
      const double inside = std::isfinite(least) ? least : near.step + 0.5 * width;
      end = at(std::max(std::min(inside, high.step - kMargin * width), near.step + kMargin * width));
      --left;
    }
    return end;
  }

  const Objective& objective_;
  const Eigen::VectorXd &low_, &high_;
  const MinimizeOptions& options_;
  MinimizeSummary best_;
  Eigen::VectorXd best_gradient_, x_, gradient_, direction_, seen_ = gradient_;
  double value_ = 0.0, slope_ = 0.0;
};

}  // namespace

MinimizeSummary conjugate_gradients(const Objective& objective, const Eigen::VectorXd& start,
                                    const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                                    const MinimizeOptions& options) {
  return Search(objective, start, low, high, options).run();
}

}  // namespace bayesctrl
