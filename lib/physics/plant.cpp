#include "physics/plant.hpp"

// Of states of any number of joints. Compiled once: inverses of matrices take the compiler long.

namespace bayesctrl {

int joints(const Plant& plant) {
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

bool may_be_shared(const Plant& plant) { return !std::holds_alternative<Custom>(plant); }

std::string unit_for(const Plant& plant, std::string_view shared) {
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

Affine affine(const Plant& plant, const JointVector& q, const JointVector& v) {
  return std::visit([&](const auto& p) -> Affine { return p.affine(q, v); }, plant);
}

Motion motion(const Plant& plant, const JointVector& q, const JointVector& v, const JointVector& u, double t) {
  return motion_of<Eigen::Dynamic>(plant, q, v, u, t);
}

JointVector external_torque(const Plant& plant, const JointVector& q) {
  return external_torque_of<Eigen::Dynamic>(plant, q);
}

}  // namespace bayesctrl
