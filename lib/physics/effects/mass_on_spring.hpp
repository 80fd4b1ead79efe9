#pragma once

#include <cmath>
#include <vector>

#include "physics/effects/added_inertia.hpp"
#include "physics/effects/joint_state.hpp"

namespace bayesctrl {

/// What the two sides of an elastic joint have in common: a mass of its own on a spring against the joint.
struct MassOnSpring {
  static constexpr bool kSwings = true;
  static constexpr bool kOnDemand = true;  // with three numbers it imitates much, and its fits take long
  double stiffness = 100.0;
  double damping = 1.0;
  double inertia = 0.1;

  using State = HiddenState<2>;  // by how much the mass is ahead of the joint, and its speed
  /// The torque on the joint.
  double spring(const State& z, const JointState& s) const { return stiffness * z[0] + damping * (z[1] - s.velocity); }
  double settling_rate(const JointState& s) const {
    const double both = 1.0 / inertia + s.mobility;
    return std::sqrt(stiffness * both) + damping * both;
  }

  /// Against a joint that stands: the frequency (rad/s), and the damping over the critical one.
  double frequency() const { return std::sqrt(stiffness / inertia); }
  double ratio() const { return 0.5 * damping / std::sqrt(stiffness * inertia); }

  /// A spring that does not give.
  AddedInertia simpler() const { return {inertia}; }

  bool operator==(const MassOnSpring&) const = default;
};

/// The effect E, whose mass on a spring is this one.
template <class E>
E on_spring(double inertia, double frequency, double ratio) {
  return {inertia * frequency * frequency, 2.0 * ratio * inertia * frequency, inertia};
}
template <class E>
std::vector<E> springs_of(const AddedInertia& law) {
  std::vector<E> list;
  for (const double frequency : {12.0, 30.0, 75.0}) list.push_back(on_spring<E>(law.inertia, frequency, 0.2));
  return list;
}

}  // namespace bayesctrl
