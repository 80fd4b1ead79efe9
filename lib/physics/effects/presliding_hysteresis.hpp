#pragma once

#include <algorithm>

#include "physics/effects/coulomb_friction.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Dahl friction: dz/dt = v - |v| z stiffness / level, torque -stiffness z.
struct PreslidingHysteresis {
  static constexpr std::string_view kName = "presliding_hysteresis";
  static constexpr std::string_view kEquation = "torque -= {stiffness} z, z' = v - |v| z {stiffness}/{level}";
  static constexpr std::string_view kText = "friction that gives like a spring before it slides";
  double stiffness = 10.0;
  double level = 0.1;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "before sliding", kRequired});
    field("level", self.level, {kPositive, "N m", "while sliding", kRequired});
  }

  using State = HiddenState<1>;
  /// Never more than the level, also from a state that is not known after a gap and may be put anywhere.
  double torque_of(const State& z, const JointState& /*s*/) const {
    return std::clamp(-stiffness * z[0], -level, level);
  }
  /// Rate at which z settles, 1/s: stiff while sliding fast.
  double settling_rate(const JointState& s) const { return std::abs(s.velocity) * stiffness / level; }
  State rate(const State& z, const JointState& s) const {
    return {s.velocity - std::abs(s.velocity) * z[0] * stiffness / level};
  }
  State settled(const State& z, const JointState& s, double h) const {
    return {relaxed(z[0], rate(z, s)[0], settling_rate(s), h)};
  }
  /// While it slides on in the same direction.
  bool is_steady(const State& z, const JointState& s) const {
    return std::abs(rate(z, s)[0]) < kSteady * std::abs(s.velocity);
  }
  static constexpr double kSteady = 1e-4;  // of the velocity, by which z still moves

  /// Without the give.
  CoulombFriction simpler() const { return {level}; }
  static std::vector<PreslidingHysteresis> extending(const CoulombFriction& law) {
    return {{law.level / 0.03, law.level}, {law.level / 0.003, law.level}};
  }

  static std::vector<Shape<PreslidingHysteresis>> shapes(const OperatingRange& s) {
    std::vector<Shape<PreslidingHysteresis>> list;
    const double range = s.highest - s.lowest;
    for (const double yield : spread(3e-4 * range, range, 12)) list.push_back({{{1.0 / yield, 1.0}}, 1});
    return list;
  }
  static PreslidingHysteresis combined(const Shape<PreslidingHysteresis>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].stiffness, c[0]};
  }
  static PreslidingHysteresis drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque / (uniform(0.01, 0.08) * s.range), s.strength * s.torque};
  }

  bool operator==(const PreslidingHysteresis&) const = default;
};

}  // namespace bayesctrl
