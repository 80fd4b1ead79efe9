#pragma once

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

  double torque_of(double z) const { return -stiffness * z; }
  /// Rate at which z settles, 1/s: stiff while sliding fast.
  double settling_rate(double velocity) const { return std::abs(velocity) * stiffness / level; }
  double rate(double velocity, double z) const { return velocity - std::abs(velocity) * z * stiffness / level; }

  /// Without the give.
  CoulombFriction simpler() const { return {level}; }
  static std::vector<PreslidingHysteresis> extending(const CoulombFriction& law) {
    return {{law.level / 0.03, law.level}, {law.level / 0.003, law.level}};
  }

  static std::vector<Shape<PreslidingHysteresis>> shapes(const Survey& s) {
    std::vector<Shape<PreslidingHysteresis>> list;
    const double range = s.highest - s.lowest;
    for (const double yield : spread(3e-4 * range, range, 12)) list.push_back({{{1.0 / yield, 1.0}}, 1});
    return list;
  }
  static PreslidingHysteresis combined(const Shape<PreslidingHysteresis>& shape, std::span<const double> c) {
    return {c[0] * shape.members[0].stiffness, c[0]};
  }

  bool operator==(const PreslidingHysteresis&) const = default;
};

}  // namespace bayesctrl
