#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include "physics/effects/joint_state.hpp"
#include "physics/effects/mass_on_spring.hpp"

namespace bayesctrl {

/// An inertia that the joint carries along by a spring. The position is measured before it.
struct ElasticLoad : MassOnSpring {
  static constexpr std::string_view kName = "elastic_load";
  static constexpr std::string_view kEquation =
      "torque += {stiffness} (l - q) + {damping} (l' - v), {inertia} l'' = -(that)";
  static constexpr std::string_view kText =
      "a load behind a gear, belt or shaft that gives like a spring, seen from the motor: it swings after the motor";

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "between joint and load", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "likewise", kRequired});
    field("inertia", self.inertia, {kPositive, "kg m^2", "of the load", kRequired});
  }

  double torque_of(const State& z, const JointState& s) const { return spring(z, s); }
  State rate(const State& z, const JointState& s) const { return {z[1] - s.velocity, -spring(z, s) / inertia}; }

  static std::vector<ElasticLoad> extending(const AddedInertia& law) { return springs_of<ElasticLoad>(law); }

  /// For each frequency and damping ratio the torque is -inertia F[q''], F a low pass; one that is hardly damped
  /// resonates within a tenth of its frequency.
  static std::vector<Shape<ElasticLoad>> shapes(const OperatingRange& s) {
    std::vector<Shape<ElasticLoad>> list;
    for (const auto& [ratio, count] : {std::pair{0.05, 28}, std::pair{0.4, 10}}) {
      for (const double frequency : spread(3.0, std::min(150.0, 1.0 / s.period), count)) {
        list.push_back({{on_spring<ElasticLoad>(1.0, frequency, ratio)}, 1});
      }
    }
    return list;
  }
  static ElasticLoad combined(const Shape<ElasticLoad>& shape, std::span<const double> c) {
    const ElasticLoad& form = shape.members[0];
    return on_spring<ElasticLoad>(c[0], form.frequency(), form.ratio());
  }
  static ElasticLoad drawn(auto&& uniform, const DrawScales& s) {
    const double inertia = s.strength * s.torque / (10.0 * s.range);
    return on_spring<ElasticLoad>(inertia, uniform(6.0, 12.0) / std::sqrt(std::max(s.strength, 1e-3)),
                                  uniform(0.1, 0.5));
  }

  bool operator==(const ElasticLoad&) const = default;
};

}  // namespace bayesctrl
