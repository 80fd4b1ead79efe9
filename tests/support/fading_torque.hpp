#pragma once

#include <algorithm>

#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// An effect that the catalogue lacks, with a hidden state of two numbers: torque -share z2, where z1 follows the
/// motor's torque and z2 follows z1. It is written as the file of an effect has to be, and nothing else knows it.
struct FadingTorque {
  static constexpr std::string_view kName = "fading_torque";
  static constexpr std::string_view kEquation =
      "torque -= {share} z2, {time_constant} z2' = z1 - z2, {time_constant} z1' = tau_in - z1";
  static constexpr std::string_view kText = "the motor loses torque while it is loaded";
  static constexpr bool kFeelsLoad = true;
  double share = 0.3;
  double time_constant = 0.5;

  static void fields(auto& self, auto&& field) {
    field("share", self.share, {kPositive, "", "of the torque", kRequired});
    field("time_constant", self.time_constant, {between(0.01, 5.0), "s", "of both", kRequired, kAnyAdmitted});
  }

  using State = HiddenState<2>;
  double torque_of(const State& z, const JointState& /*s*/) const { return -share * z[1]; }
  double settling_rate(const JointState& /*s*/) const { return 1.0 / time_constant; }
  State rate(const State& z, const JointState& s) const {
    return {(s.motor_torque - z[0]) / time_constant, (z[0] - z[1]) / time_constant};
  }

  static std::vector<Shape<FadingTorque>> shapes(const OperatingRange& /*s*/) {
    std::vector<Shape<FadingTorque>> list;
    for (const double tried : spread(0.05, 2.0, 60)) list.push_back({{{1.0, tried}}, 1});
    return list;
  }
  static FadingTorque combined(const Shape<FadingTorque>& shape, std::span<const double> c) {
    return {c[0], shape.members[0].time_constant};
  }
  static FadingTorque drawn(auto&& uniform, const DrawScales& s) {
    return {std::min(s.strength, 0.9), uniform(0.2, 1.0)};
  }

  bool operator==(const FadingTorque&) const = default;
};

}  // namespace bayesctrl
