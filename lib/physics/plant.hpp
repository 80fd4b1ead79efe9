#pragma once

#include <Eigen/LU>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>

#include "physics/plants/custom.hpp"
#include "physics/plants/mass.hpp"
#include "physics/plants/pendulum.hpp"
#include "physics/plants/two_link_arm.hpp"

namespace bayesctrl {

/// Fully actuated mechanics, one input per joint. A new plant is one file in plants/ and one line here.
using Plant = std::variant<Pendulum, Mass, TwoLinkArm, Custom>;

/// Calls f(plant, std::integral_constant<int, joints>): the number of joints is a constant, so that states are arrays.
decltype(auto) with_joints(const Plant& plant, auto&& f) {
  return std::visit(
      [&]<class P>(const P& p) {
        if constexpr (requires { P::kJoints; }) {
          return f(p, std::integral_constant<int, P::kJoints>{});
        } else {
          static_assert(kMaxJoints == 4);
          switch (p.joint_count()) {
            case 1:
              return f(p, std::integral_constant<int, 1>{});
            case 2:
              return f(p, std::integral_constant<int, 2>{});
            case 3:
              return f(p, std::integral_constant<int, 3>{});
            default:
              return f(p, std::integral_constant<int, 4>{});
          }
        }
      },
      plant);
}

inline int joints(const Plant& plant) {
  return std::visit(
      []<class P>(const P& p) {
        if constexpr (requires { P::kJoints; }) {
          return P::kJoints;
        } else {
          return p.joint_count();
        }
      },
      plant);
}

/// A unit that all plants share, "rad or m", as it is for this one; where nobody but the user knows it, as it was.
inline std::string unit_for(const Plant& plant, std::string_view shared) {
  return std::visit(
      [&]<class P>(const P&) {
        const std::string q(P::kPositionUnit), u(P::kInputUnit);
        if (q.empty()) return std::string(shared);
        if (shared == "rad or m") return q;
        if (shared == "rad/s or m/s") return q + "/s";
        if (shared == "N m or N" || shared == "unit of u") return u;
        if (shared == "u^2 s") return u.find(' ') == std::string::npos ? u + "^2 s" : "(" + u + ")^2 s";
        return std::string(shared);
      },
      plant);
}

/// a(x) and b(x) at x = [q, v].
inline Affine affine(const Plant& plant, const JointVector& q, const JointVector& v) {
  return std::visit([&](const auto& p) { return p.affine(q, v); }, plant);
}

/// Nominal mechanics at one instant.
struct Motion {
  JointVector acceleration;  // q''
  JointMatrix mobility;      // inverse inertia: what a torque in each joint adds to q''
};

inline Motion motion(const Plant& plant, const JointVector& q, const JointVector& v, const JointVector& u, double t) {
  return std::visit(
      [&](const auto& p) -> Motion {
        if constexpr (requires { p.mobility(q, v); }) {
          return {p.acceleration(q, v, u, t), p.mobility(q, v)};
        } else {  // inputs are torques
          const Affine nominal = p.affine(q, v);
          return {nominal.drift + nominal.gain * u, nominal.gain};
        }
      },
      plant);
}

/// Torque of gravity and springs along q: what would move the joints from rest without input.
inline JointVector external_torque(const Plant& plant, const JointVector& q) {
  const JointVector none = JointVector::Zero(q.size());
  const Motion still = motion(plant, q, none, none, 0.0);
  if (q.size() == 1) return still.acceleration / still.mobility(0, 0);
  return still.mobility.partialPivLu().solve(still.acceleration);
}

}  // namespace bayesctrl
