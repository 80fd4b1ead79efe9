#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// A spring from a lever on the link to an anchor on the frame: torque -stiffness (1 - rest / d) sin(q - centre),
/// d = sqrt(1 + anchor^2 - 2 anchor cos(q - centre)). Lengths count in levers; the stiffness is the spring's (N/m)
/// times lever and anchor distance.
struct Counterbalance {
  static constexpr std::string_view kName = "counterbalance";
  static constexpr std::string_view kEquation =
      "torque -= {stiffness} (1 - {rest}/d) sin(q - {centre}), d^2 = 1 + {anchor}^2 - 2 {anchor} cos(q - {centre})";
  static constexpr std::string_view kText = "a spring on a lever, as it carries the weight of an arm";
  static constexpr bool kNeedsTurning = true;
  static constexpr bool kSpring = true;
  static constexpr bool kOnDemand = true;  // in small ranges it imitates any spring
  double stiffness = 1.0;
  double anchor = 2.0;
  double rest = 0.5;
  double centre = 0.0;

  static void fields(auto& self, auto&& field) {
    field("stiffness", self.stiffness, {kPositive, "N m/rad", "of the spring, times lever and anchor", kRequired});
    field("anchor", self.anchor,
          {between(1.1, 5.0), "levers", "from the axis to the spring's other end", kRequired, kAnyAdmitted});
    field("rest", self.rest,
          {Range{.low = 0.0, .high = 5.0}, "levers", "length of the spring without force", kRequired, kAnyAdmitted});
    field("centre", self.centre, {kAny, "rad", "position in which lever and anchor are in line", kRequired, kAngle});
  }

  double torque_at(const JointState& s) const {
    const double angle = s.position - centre;
    const double length = std::sqrt(1.0 + anchor * anchor - 2.0 * anchor * std::cos(angle));
    return -stiffness * (1.0 - rest / length) * std::sin(angle);
  }

  /// Linear in the stiffness and in its product with the rest length.
  static std::vector<Shape<Counterbalance>> shapes(const OperatingRange& /*s*/) {
    constexpr double kNext = 1e-6;  // to nothing
    constexpr int kCentres = 16;
    std::vector<Shape<Counterbalance>> list;
    for (const double anchor : {1.3, 2.0, 3.5}) {
      for (int i = 0; i < kCentres; ++i) {
        const double centre = 2.0 * std::numbers::pi * i / kCentres;
        list.push_back({{{1.0, anchor, 0.0, centre}, {kNext, anchor, 1.0 / kNext, centre}}, 1});
      }
    }
    return list;
  }
  static Counterbalance combined(const Shape<Counterbalance>& shape, std::span<const double> c) {
    Counterbalance spring = shape.members[0];
    constexpr double kLongest = 5.0;
    spring.stiffness = std::max({c[0], c[1] / kLongest, 1e-9});
    spring.rest = c[1] / spring.stiffness;
    return spring;
  }
  static Counterbalance drawn(auto&& uniform, const DrawScales& s) {
    return {s.strength * s.torque, uniform(1.3, 3.0), uniform(0.1, 0.8), uniform(-1.5, 1.5)};
  }

  bool operator==(const Counterbalance&) const = default;
};

}  // namespace bayesctrl
