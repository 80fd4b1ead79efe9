#pragma once

#include "physics/effects/joint_state.hpp"
#include "physics/effects/viscous_friction.hpp"

namespace bayesctrl {

/// Torque -forward v for v > 0 and -backward v for v < 0, viscous only.
struct AsymmetricFriction {
  static constexpr std::string_view kName = "asymmetric_friction";
  static constexpr std::string_view kEquation = "torque -= (v > 0 ? {forward} : {backward}) v";
  static constexpr std::string_view kText =
      "drag that differs between the two directions, as from worn or preloaded parts";
  using Contains = ViscousFriction;  // beside it that law adds nothing
  double forward = 0.1;
  double backward = 0.1;

  static void fields(auto& self, auto&& field) {
    field("forward", self.forward, {kNonNegative, "N m s/rad", "coefficient for v > 0", kRequired});
    field("backward", self.backward, {kNonNegative, "N m s/rad", "coefficient for v < 0", kRequired});
  }

  double torque_at(const JointState& s) const { return -(s.velocity > 0.0 ? forward : backward) * s.velocity; }

  /// The same in both directions.
  ViscousFriction simpler() const { return {0.5 * (forward + backward)}; }
  static std::vector<AsymmetricFriction> extending(const ViscousFriction& law) {
    return {{law.coefficient, law.coefficient}};
  }

  static std::vector<Shape<AsymmetricFriction>> shapes(const OperatingRange& /*s*/) {
    return {{{{1.0, 0.0}, {0.0, 1.0}}, 1}};
  }
  static AsymmetricFriction combined(const Shape<AsymmetricFriction>& /*shape*/, std::span<const double> c) {
    return {c[0], c[1]};
  }
  static AsymmetricFriction drawn(auto&& uniform, const DrawScales& s) {
    const double drag = s.strength * s.torque / s.speed;
    return {drag, drag * uniform(0.1, 0.6)};
  }

  bool operator==(const AsymmetricFriction&) const = default;
};

}  // namespace bayesctrl
