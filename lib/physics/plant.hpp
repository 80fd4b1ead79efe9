#pragma once

#include <variant>

#include "physics/plants/mass.hpp"
#include "physics/plants/pendulum.hpp"
#include "physics/plants/two_link_arm.hpp"

namespace bayesctrl {

/// Fully actuated mechanics, one input per joint. A new plant is one file in plants/ and one line here.
using Plant = std::variant<Pendulum, Mass, TwoLinkArm>;

inline int joints(const Plant& plant) {
  return std::visit([](const auto& p) { return std::decay_t<decltype(p)>::kJoints; }, plant);
}

/// a(x) and b(x) at x = [q, v].
inline Affine affine(const Plant& plant, const JointVector& q, const JointVector& v) {
  return std::visit([&](const auto& p) { return p.affine(q, v); }, plant);
}

}  // namespace bayesctrl
