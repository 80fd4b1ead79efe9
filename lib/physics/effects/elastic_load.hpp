#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/effects/added_inertia.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// An inertia that the joint carries along by a spring. The position is measured before it.
struct ElasticLoad {
  static constexpr std::string_view kName = "elastic_load";
  static constexpr std::string_view kEquation =
      "torque += {stiffness} (l - q) + {damping} (l' - v), {inertia} l'' = -(that)";
  static constexpr std::string_view kText =
      "a load behind a gear, belt or shaft that gives like a spring, seen from the motor: it swings after the motor";
  static constexpr bool kSwings = true;
  static constexpr bool kOnDemand = true;  // as joint_elasticity
  double stiffness = 100.0;
  double damping = 1.0;
  double inertia = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "between joint and load", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "likewise", kRequired});
    field("inertia", self.inertia, {kPositive, "kg m^2", "of the load", kRequired});
  }

  using State = HiddenState<2>;  // l - q, l'
  double torque_of(const State& z, const JointState& s) const {
    return stiffness * z[0] + damping * (z[1] - s.velocity);
  }
  double settling_rate(const JointState& s) const {
    const double both = 1.0 / inertia + s.mobility;
    return std::sqrt(stiffness * both) + damping * both;
  }
  State rate(const State& z, const JointState& s) const { return {z[1] - s.velocity, -torque_of(z, s) / inertia}; }

  /// A spring that does not give.
  AddedInertia simpler() const { return {inertia}; }
  static std::vector<ElasticLoad> extending(const AddedInertia& law) {
    std::vector<ElasticLoad> list;
    for (const double frequency : {12.0, 30.0, 75.0}) list.push_back(of(law.inertia, frequency, 0.2));
    return list;
  }

  /// For each frequency and damping ratio the torque is -inertia F[q''], F a low pass; one that is hardly damped
  /// resonates within a tenth of its frequency.
  static std::vector<Shape<ElasticLoad>> shapes(const OperatingRange& s) {
    std::vector<Shape<ElasticLoad>> list;
    for (const auto& [ratio, count] : {std::pair{0.05, 28}, std::pair{0.4, 10}}) {
      for (const double frequency : spread(3.0, std::min(150.0, 1.0 / s.period), count)) {
        list.push_back({{of(1.0, frequency, ratio)}, 1});
      }
    }
    return list;
  }
  static ElasticLoad combined(const Shape<ElasticLoad>& shape, std::span<const double> c) {
    const ElasticLoad& form = shape.members[0];
    return of(c[0], form.frequency(), form.ratio());
  }
  static ElasticLoad drawn(auto&& uniform, const DrawScales& s) {
    const double inertia = s.strength * s.torque / (10.0 * s.range);
    return of(inertia, uniform(6.0, 12.0) / std::sqrt(std::max(s.strength, 1e-3)), uniform(0.1, 0.5));
  }

  bool operator==(const ElasticLoad&) const = default;

 private:
  /// Of the load at a joint that stands: its frequency (rad/s), and the damping over the critical one.
  double frequency() const { return std::sqrt(stiffness / inertia); }
  double ratio() const { return 0.5 * damping / std::sqrt(stiffness * inertia); }
  static ElasticLoad of(double inertia, double frequency, double ratio) {
    return {inertia * frequency * frequency, 2.0 * ratio * inertia * frequency, inertia};
  }
};

}  // namespace bayesctrl
