#pragma once

#include <algorithm>
#include <cmath>

#include "physics/effects/added_inertia.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// The input moves a motor, and that the joint through a spring. The position is measured behind it.
struct JointElasticity {
  static constexpr std::string_view kName = "joint_elasticity";
  static constexpr std::string_view kEquation =
      "torque := {stiffness} (m - q) + {damping} (m' - v), {inertia} m'' = tau_in - torque";
  static constexpr std::string_view kText =
      "a gear, belt or shaft between motor and joint that gives like a spring, so that the motor swings against it";
  static constexpr bool kFeelsLoad = true;
  static constexpr bool kSwings = true;
  static constexpr bool kOnDemand = true;  // with three numbers it imitates much, and its fits take long
  double stiffness = 100.0;
  double damping = 1.0;
  double inertia = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "between motor and joint", kRequired});
    field("damping", self.damping, {kPositive, "N m s/rad", "likewise", kRequired});
    field("inertia", self.inertia, {kPositive, "kg m^2", "of the motor, seen from the joint", kRequired});
  }

  using State = HiddenState<2>;  // m - q, m'
  double torque_of(const State& z, const JointState& s) const { return spring(z, s) - s.motor_torque; }
  double settling_rate(const JointState& s) const {
    const double both = 1.0 / inertia + s.mobility;
    return std::sqrt(stiffness * both) + damping * both;
  }
  State rate(const State& z, const JointState& s) const {
    return {z[1] - s.velocity, (s.motor_torque - spring(z, s)) / inertia};
  }

  /// A spring that does not give.
  AddedInertia simpler() const { return {inertia}; }
  static std::vector<JointElasticity> extending(const AddedInertia& law) {
    std::vector<JointElasticity> list;
    for (const double frequency : {12.0, 30.0, 75.0}) list.push_back(of(law.inertia, frequency, 0.2));
    return list;
  }

  /// For each frequency and damping ratio the torque is F[tau_in] - tau_in - inertia F[q''], F a low pass: linear in
  /// the inertia. The first member has next to none.
  static std::vector<Shape<JointElasticity>> shapes(const OperatingRange& s) {
    std::vector<Shape<JointElasticity>> list;
    if (s.input == 0.0) return list;
    for (const double ratio : {0.05, 0.4}) {
      for (const double frequency : spread(5.0, std::min(150.0, 1.0 / s.period), 9)) {
        list.push_back({{of(kLeast, frequency, ratio), of(1.0, frequency, ratio)}});
      }
    }
    return list;
  }
  /// One low pass that gives as much as all of them.
  static JointElasticity combined(const Shape<JointElasticity>& shape, std::span<const double> c) {
    const JointElasticity& form = shape.members[1];
    const double share = std::clamp(c[0] + c[1], 0.05, 20.0);
    return of(std::max(c[1] / share, kLeast), form.frequency() / std::sqrt(share), form.ratio());
  }
  static JointElasticity drawn(auto&& uniform, const DrawScales& s) {
    const double inertia = s.strength * s.torque / (10.0 * s.range);
    return of(inertia, uniform(6.0, 12.0) / std::sqrt(std::max(s.strength, 1e-3)), uniform(0.1, 0.5));
  }

  bool operator==(const JointElasticity&) const = default;

 private:
  static constexpr double kLeast = 1e-4;  // kg m^2

  /// Of the motor against a joint that stands: its frequency (rad/s), and the damping over the critical one.
  double frequency() const { return std::sqrt(stiffness / inertia); }
  double ratio() const { return 0.5 * damping / std::sqrt(stiffness * inertia); }
  static JointElasticity of(double inertia, double frequency, double ratio) {
    return {inertia * frequency * frequency, 2.0 * ratio * inertia * frequency, inertia};
  }

  double spring(const State& z, const JointState& s) const { return stiffness * z[0] + damping * (z[1] - s.velocity); }
};

}  // namespace bayesctrl
