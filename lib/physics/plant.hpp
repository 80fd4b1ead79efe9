#pragma once

#include <Eigen/LU>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "physics/plants/custom.hpp"
#include "physics/plants/mass.hpp"
#include "physics/plants/pendulum.hpp"
#include "physics/plants/planar_arm.hpp"
#include "physics/plants/two_link_arm.hpp"

namespace bayesctrl {

/// Fully actuated mechanics, one input per joint. A new plant is one file in plants/ and one line here.
using Plant = std::variant<Pendulum, Mass, TwoLinkArm, PlanarArm, Custom>;

/// Calls f(std::integral_constant<int, n>) of a number from kFrom to kMaxJoints.
template <int kFrom>
decltype(auto) with_count(int n, auto&& f) {
  if constexpr (kFrom < kMaxJoints) {
    if (n > kFrom) return with_count<kFrom + 1>(n, f);
  }
  return f(std::integral_constant<int, kFrom>{});
}

/// Calls f(plant, std::integral_constant<int, joints>): the number of joints is a constant, so that states are arrays.
decltype(auto) with_joints(const Plant& plant, auto&& f) {
  return std::visit(
      [&]<class P>(const P& p) {
        if constexpr (requires { P::kJoints; }) {
          return f(p, std::integral_constant<int, P::kJoints>{});
        } else {
          return with_count<1>(p.joint_count(), [&](auto count) -> decltype(auto) { return f(p, count); });
        }
      },
      plant);
}

int joints(const Plant& plant);

/// Whether several threads may evaluate one object at a time; else each needs a copy.
bool may_be_shared(const Plant& plant);

/// Whether a plant of this type may have so many; Eigen::Dynamic: any.
template <class P>
constexpr bool may_have_joints(int count) {
  if constexpr (requires { P::kJoints; }) {
    return count == Eigen::Dynamic || count == P::kJoints;
  } else {
    return true;
  }
}

/// A unit that all plants share, "rad or m", as it is for this one; where nobody but the user knows it, as it was.
std::string unit_for(const Plant& plant, std::string_view shared);

/// a(x) and b(x) at x = [q, v].
Affine affine(const Plant& plant, const JointVector& q, const JointVector& v);

/// Nominal mechanics at one instant; the number of joints may be a constant.
template <int kJoints>
struct MotionOf {
  Joints<kJoints> acceleration;    // q''
  JointsSquare<kJoints> mobility;  // inverse inertia: what a torque in each joint adds to q''
};
using Motion = MotionOf<Eigen::Dynamic>;

/// Accelerations and what torques add to them. All are written one by one, so they are read one by one: a processor
/// waits for what it reads as a whole.
template <int kJoints>
[[gnu::always_inline]] inline Joints<kJoints> moved_by(const Joints<kJoints>& acceleration,
                                                       const JointsSquare<kJoints>& mobility,
                                                       const Joints<kJoints>& torque) {
  Joints<kJoints> result(torque.size());
  for (Eigen::Index i = 0; i < torque.size(); ++i) {
    double sum = acceleration[i];
    for (Eigen::Index j = 0; j < torque.size(); ++j) sum += mobility(i, j) * torque[j];
    result[i] = sum;
  }
  return result;
}

/// The torques that would accelerate the joints so.
template <int kJoints>
Joints<kJoints> inverse_dynamics(const JointsSquare<kJoints>& mobility, const Joints<kJoints>& acceleration) {
  if (acceleration.size() == 1) return acceleration / mobility(0, 0);
  return mobility.inverse() * acceleration;
}

template <int kJoints>
MotionOf<kJoints> motion_of(const Plant& plant, const Joints<kJoints>& q, const Joints<kJoints>& v,
                            const Joints<kJoints>& u, double t) {
  return std::visit(
      [&]<class P>(const P& p) -> MotionOf<kJoints> {
        if constexpr (requires { p.mobility(q, v); }) {
          return {p.acceleration(q, v, u, t), p.mobility(q, v)};
        } else if constexpr (may_have_joints<P>(kJoints)) {  // inputs are torques
          const auto nominal = p.affine(q, v);
          return {moved_by<kJoints>(nominal.drift, nominal.gain, u), nominal.gain};
        } else {
          return {};
        }
      },
      plant);
}

Motion motion(const Plant& plant, const JointVector& q, const JointVector& v, const JointVector& u, double t);

/// Torque of gravity and springs along q: what would move the joints from rest without input.
template <int kJoints>
Joints<kJoints> external_torque_of(const Plant& plant, const Joints<kJoints>& q) {
  const auto from_rest = [&]() -> Joints<kJoints> {
    const Joints<kJoints> none = Joints<kJoints>::Zero(q.size());
    const MotionOf<kJoints> still = motion_of<kJoints>(plant, q, none, none, 0.0);
    return inverse_dynamics<kJoints>(still.mobility, still.acceleration);
  };
  return std::visit(
      [&]<class P>(const P& p) -> Joints<kJoints> {
        if constexpr (requires { p.external_torque(q); }) {  // which says it directly
          if constexpr (may_have_joints<P>(kJoints)) return p.external_torque(q);
        }
        return from_rest();
      },
      plant);
}

JointVector external_torque(const Plant& plant, const JointVector& q);

}  // namespace bayesctrl
