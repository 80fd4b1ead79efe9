#pragma once

#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "base/fields.hpp"
#include "base/vector.hpp"

namespace bayesctrl {

/// Where the machine should be at one time: position, velocity and acceleration of each joint.
struct ReferencePoint {
  JointVector position, velocity, acceleration;
};

/// The paper's goal state xi = [position, 0], from the start on.
struct Setpoint {
  static constexpr std::string_view kName = "setpoint";
  static constexpr std::string_view kText = "hold one position";
  std::vector<double> position{0.0};

  static void fields(auto& self, auto&& field) {
    field("position", self.position, {kAny, "rad or m", "one per joint", kRequired});
  }

  int joints() const { return static_cast<int>(position.size()); }

  ReferencePoint at(double /*t*/) const {
    const auto n = static_cast<Eigen::Index>(position.size());
    return {Eigen::Map<const Eigen::VectorXd>(position.data(), n), JointVector::Zero(n), JointVector::Zero(n)};
  }
  bool operator==(const Setpoint&) const = default;
};

/// centre + amplitude sin(frequency t) in each joint.
struct Sine {
  static constexpr std::string_view kName = "sine";
  static constexpr std::string_view kText = "follow centre + amplitude sin(frequency t)";
  std::vector<double> centre{0.0};
  std::vector<double> amplitude{1.0};
  std::vector<double> frequency{1.0};

  static void fields(auto& self, auto&& field) {
    field("centre", self.centre, {kAny, "rad or m", "one per joint", kRequired});
    field("amplitude", self.amplitude, {kAny, "rad or m", "one per joint", kRequired});
    field("frequency", self.frequency, {kPositive, "rad/s", "one per joint", kRequired});
  }

  std::string problem() const {
    return centre.size() == amplitude.size() && centre.size() == frequency.size()
               ? ""
               : "sine needs as many amplitudes and frequencies as centres";
  }

  int joints() const { return static_cast<int>(centre.size()); }

  ReferencePoint at(double t) const {
    const auto n = static_cast<Eigen::Index>(centre.size());
    ReferencePoint point{JointVector(n), JointVector(n), JointVector(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      const double w = frequency[i];
      point.position[i] = centre[i] + amplitude[i] * std::sin(w * t);
      point.velocity[i] = amplitude[i] * w * std::cos(w * t);
      point.acceleration[i] = -amplitude[i] * w * w * std::sin(w * t);
    }
    return point;
  }
  bool operator==(const Sine&) const = default;
};

/// from + (to - from) / (1 + exp(-rate (t - time))) in each joint.
struct SmoothStep {
  static constexpr std::string_view kName = "smooth_step";
  static constexpr std::string_view kText = "go from one position to another about a time, as a logistic function";
  std::vector<double> from{0.0};
  std::vector<double> to{1.0};
  std::vector<double> time{1.0};
  std::vector<double> rate{1.0};

  static void fields(auto& self, auto&& field) {
    field("from", self.from, {kAny, "rad or m", "one per joint", kRequired});
    field("to", self.to, {kAny, "rad or m", "one per joint", kRequired});
    field("time", self.time, {kAny, "s", "when it is half way, one per joint", kRequired});
    field("rate", self.rate, {kPositive, "1/s", "of the logistic function, one per joint", kRequired});
  }

  std::string problem() const {
    return from.size() == to.size() && from.size() == time.size() && from.size() == rate.size()
               ? ""
               : "smooth_step needs as many numbers in to, time and rate as in from";
  }

  int joints() const { return static_cast<int>(from.size()); }

  ReferencePoint at(double t) const {
    const auto n = static_cast<Eigen::Index>(from.size());
    ReferencePoint point{JointVector(n), JointVector(n), JointVector(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      const double way = to[i] - from[i], share = 1.0 / (1.0 + std::exp(-rate[i] * (t - time[i])));
      const double slope = rate[i] * share * (1.0 - share);
      point.position[i] = from[i] + way * share;
      point.velocity[i] = way * slope;
      point.acceleration[i] = way * rate[i] * slope * (1.0 - 2.0 * share);
    }
    return point;
  }
  bool operator==(const SmoothStep&) const = default;
};

using Reference = std::variant<Setpoint, Sine, SmoothStep>;

inline ReferencePoint at(const Reference& reference, double t) {
  return std::visit([t](const auto& form) { return form.at(t); }, reference);
}

inline int joints(const Reference& reference) {
  return std::visit([](const auto& form) { return form.joints(); }, reference);
}

}  // namespace bayesctrl
