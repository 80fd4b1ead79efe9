#pragma once

#include <algorithm>

#include "physics/effects/coulomb_friction.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// Dry friction -(coulomb + (static - coulomb) exp(-(v/velocity)^2)) sign v; sticks at static_level.
struct StribeckFriction {
  static constexpr std::string_view kName = "stribeck_friction";
  static constexpr std::string_view kEquation =
      "torque -= ({coulomb} + ({static} - {coulomb}) exp(-(v/{velocity})^2)) sign(v)";
  static constexpr std::string_view kText =
      "dry friction that is stronger at rest than in motion, so that slow motion sticks and slips";
  using Contains = CoulombFriction;  // beside it that law adds nothing
  double coulomb = 0.1;
  double static_level = 0.2;
  double velocity = 0.1;

  /// Friction at rest is seldom more than three times that in motion.
  static void fields(auto& self, auto&& field) {
    field("coulomb", self.coulomb, {kPositive, "N m", "friction at speed", kRequired});
    field("static", self.static_level,
          {kPositive,
           "N m",
           "friction at rest",
           kRequired,
           {.mean = self.coulomb, .deviation = {std::max(self.coulomb, 0.5 * self.static_level)}}});
    field("velocity", self.velocity,
          {between(0.01, 1.0), "rad/s", "speed at which it falls off", kRequired, kAnyAdmitted});
  }

  std::string problem() const { return static_level >= coulomb ? "" : "static must be at least coulomb"; }

  /// Moves parameters that a search has left where they contradict each other.
  void admit() { static_level = std::max(static_level, coulomb); }

  /// Magnitude while sliding, and the largest torque that it resists at rest.
  double sliding(const JointState& s) const {
    const double ratio = s.velocity / velocity;
    return coulomb + (static_level - coulomb) * std::exp(-ratio * ratio);
  }
  double holding(const JointState& /*s*/) const { return static_level; }

  /// Without the rise towards rest.
  CoulombFriction simpler() const { return {coulomb}; }
  static std::vector<StribeckFriction> extending(const CoulombFriction& law) {
    return {{law.level, 1.6 * law.level, 0.03}, {law.level, 1.6 * law.level, 0.1}, {law.level, 1.6 * law.level, 0.3}};
  }

  static std::vector<Shape<StribeckFriction>> shapes(const OperatingRange& s) {
    std::vector<Shape<StribeckFriction>> list;
    for (const double knee : spread(0.01, std::min(1.0, s.speed), 10)) {
      list.push_back({{{1.0, 1.0, knee}, {0.0, 1.0, knee}}, 1});
    }
    return list;
  }
  static StribeckFriction combined(const Shape<StribeckFriction>& shape, std::span<const double> c) {
    return {c[0], c[0] + c[1], shape.members[0].velocity};
  }
  static StribeckFriction drawn(auto&& uniform, const DrawScales& s) {
    const double level = s.strength * s.torque;
    return {level, level * uniform(1.4, 2.5), uniform(0.05, 0.4)};
  }

  bool operator==(const StribeckFriction&) const = default;
};

}  // namespace bayesctrl
