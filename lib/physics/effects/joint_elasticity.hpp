#pragma once

#include <algorithm>
#include <cmath>

#include "physics/effects/joint_state.hpp"
#include "physics/effects/mass_on_spring.hpp"

namespace bayesctrl {

/// The input moves a motor, and that the joint through a spring. The position is measured behind it.
struct JointElasticity : MassOnSpring {
  static constexpr std::string_view kName = "joint_elasticity";
  static constexpr std::string_view kEquation =
      "torque := {stiffness} (m - q) + {damping} (m' - v), {inertia} m'' = tau_in - torque";
  static constexpr std::string_view kText =
      "a gear, belt or shaft between motor and joint that gives like a spring, so that the motor swings against it";
  static constexpr bool kFeelsLoad = true;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "between motor and joint", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "likewise", kRequired});
    field("inertia", self.inertia, {kPositive, "kg m^2", "of the motor, seen from the joint", kRequired});
  }

  double torque_of(const State& z, const JointState& s) const { return spring(z, s) - s.motor_torque; }
  State rate(const State& z, const JointState& s) const {
    return {z[1] - s.velocity, (s.motor_torque - spring(z, s)) / inertia};
  }

  static std::vector<JointElasticity> extending(const AddedInertia& law) { return springs_of<JointElasticity>(law); }

  /// For each frequency and damping ratio the torque is F[tau_in] - tau_in - inertia F[q''], F a low pass: linear in
  /// the inertia. The first member has next to none.
  static std::vector<Shape<JointElasticity>> shapes(const OperatingRange& s) {
    std::vector<Shape<JointElasticity>> list;
    if (s.input == 0.0) return list;
    for (const double ratio : {0.05, 0.4}) {
      for (const double frequency : spread(5.0, std::min(150.0, 1.0 / s.period), 9)) {
        list.push_back({{on_spring<JointElasticity>(kLeast, frequency, ratio),
                         on_spring<JointElasticity>(1.0, frequency, ratio)}});
      }
    }
    return list;
  }
  /// One low pass that gives as much as all of them.
  static JointElasticity combined(const Shape<JointElasticity>& shape, std::span<const double> c) {
    const JointElasticity& form = shape.members[1];
    const double share = std::clamp(c[0] + c[1], 0.05, 20.0);
    return on_spring<JointElasticity>(std::max(c[1] / share, kLeast), form.frequency() / std::sqrt(share),
                                      form.ratio());
  }
  static JointElasticity drawn(auto&& uniform, const DrawScales& s) {
    const double inertia = s.strength * s.torque / (10.0 * s.range);
    return on_spring<JointElasticity>(inertia, uniform(6.0, 12.0) / std::sqrt(std::max(s.strength, 1e-3)),
                                      uniform(0.1, 0.5));
  }

  bool operator==(const JointElasticity&) const = default;

 private:
  static constexpr double kLeast = 1e-4;  // kg m^2
};

}  // namespace bayesctrl
