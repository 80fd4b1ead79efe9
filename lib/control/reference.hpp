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

using Reference = std::variant<Setpoint, Sine>;

inline ReferencePoint at(const Reference& reference, double t) {
  return std::visit([t](const auto& form) { return form.at(t); }, reference);
}

inline int joints(const Reference& reference) {
  return std::visit([](const auto& form) { return form.joints(); }, reference);
}

}  // namespace bayesctrl
