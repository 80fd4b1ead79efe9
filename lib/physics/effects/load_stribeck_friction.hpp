#pragma once

#include <algorithm>
#include <cmath>

#include "physics/effects/joint_state.hpp"
#include "physics/effects/load_dependent_friction.hpp"

namespace bayesctrl {

/// Dry friction -(k + (static - k) exp(-(v/velocity)^2)) |tau_in - tau_ext| sign v; at rest it holds up to static times
/// the load.
struct LoadStribeckFriction {
  static constexpr std::string_view kName = "load_stribeck_friction";
  static constexpr std::string_view kEquation =
      "torque -= ({k} + ({static} - {k}) exp(-(v/{velocity})^2)) |tau_in - tau_ext| sign(v)";
  static constexpr std::string_view kText =
      "dry friction that grows with the load and falls with the speed, as in worm and strain wave gears";
  static constexpr bool kFeelsLoad = true;
  static constexpr bool kOnDemand = true;  // with three numbers it imitates much
  using Contains = LoadDependentFriction;  // beside it that law adds nothing
  double k = 0.05;
  double static_share = 0.1;
  double velocity = 0.1;

  static void fields(auto& self, auto&& field) {
    constexpr Range kShare{.low = 0.0, .high = 1.0, .low_open = true, .high_open = true};
    field("k", self.k, {kShare, "", "share of the load at speed", kRequired, kAnyAdmitted});
    field("static", self.static_share, {kShare, "", "share of the load at rest", kRequired, kAnyAdmitted});
    field("velocity", self.velocity,
          {between(0.01, 1.0), "rad/s", "speed at which it falls off", kRequired, kAnyAdmitted});
  }

  std::string problem() const { return static_share >= k ? "" : "static must be at least k"; }
  void admit() { static_share = std::max(static_share, k); }

  /// Magnitude while sliding, and the largest torque that it resists at rest.
  double sliding(const JointState& s) const {
    const double ratio = s.velocity / velocity;
    return (k + (static_share - k) * std::exp(-ratio * ratio)) * s.load();
  }
  double holding(const JointState& s) const { return static_share * s.load(); }

  /// Without the rise towards rest.
  LoadDependentFriction simpler() const { return {k}; }
  static std::vector<LoadStribeckFriction> extending(const LoadDependentFriction& law) {
    const double rises = std::min(1.6 * law.k, 0.99);
    return {{law.k, rises, 0.03}, {law.k, rises, 0.1}, {law.k, rises, 0.3}};
  }

  static std::vector<Shape<LoadStribeckFriction>> shapes(const OperatingRange& s) {
    std::vector<Shape<LoadStribeckFriction>> list;
    for (const double knee : spread(0.01, std::min(1.0, s.speed), 10)) {
      list.push_back({{{1.0, 1.0, knee}, {0.0, 1.0, knee}}, 1});
    }
    return list;
  }
  static LoadStribeckFriction combined(const Shape<LoadStribeckFriction>& shape, std::span<const double> c) {
    return {c[0], c[0] + c[1], shape.members[0].velocity};
  }
  static LoadStribeckFriction drawn(auto&& uniform, const DrawScales& s) {
    const double k = std::min(s.strength, 0.5);
    return {k, k * uniform(1.3, 1.9), uniform(0.05, 0.4)};
  }

  bool operator==(const LoadStribeckFriction&) const = default;
};

}  // namespace bayesctrl
