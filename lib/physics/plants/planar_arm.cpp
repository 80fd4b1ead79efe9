#include "physics/plants/planar_arm.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <numbers>

#include "base/format.hpp"

namespace bayesctrl {

namespace {

double of_link(const std::vector<double>& list, int i) {
  return list.size() == 1 ? list.front() : list[static_cast<std::size_t>(i)];
}

/// Moments of mass of the links, all that is beyond their next joint hanging there: m_i c_i + l_i sum_{k > i} m_k.
JointVector moments(const PlanarArm& arm) {
  const int n = arm.joint_count();
  JointVector result(n);
  double beyond = 0.0;
  for (int i = n - 1; i >= 0; --i) {
    result[i] = of_link(arm.mass, i) * of_link(arm.com, i) + of_link(arm.length, i) * beyond;
    beyond += of_link(arm.mass, i);
  }
  return result;
}

/// Angles of the links to the vertical from those of the joints, or their velocities.
JointVector absolute(const JointVector& q) {
  JointVector result = q;
  for (Eigen::Index i = 1; i < q.size(); ++i) result[i] += result[i - 1];
  return result;
}

/// Torques along the joints from those along absolute angles: a joint turns all links beyond it.
JointVector along_joints(JointVector torque) {
  for (Eigen::Index i = torque.size() - 2; i >= 0; --i) torque[i] += torque[i + 1];
  return torque;
}

JointVector gravity_torque(const PlanarArm& arm, const JointVector& moment, const JointVector& angle) {
  return along_joints(-arm.gravity * moment.cwiseProduct(angle.array().sin().matrix()));
}

}  // namespace

std::string PlanarArm::problem() const {
  const int n = joint_count();
  if (n < 1 || n > kMaxJoints) return "length needs one number for each link, at most " + std::to_string(kMaxJoints);
  std::string text;
  fields(*this, [&]<class T>(std::string_view name, const T& list, const Info&) {
    if constexpr (!std::is_same_v<T, double>) {
      if (text.empty() && list.size() != 1 && static_cast<int>(list.size()) != n) {
        text = std::string(name) + " has " + std::to_string(list.size()) + " numbers for " + std::to_string(n) +
               " links: one for all or one for each";
      }
    }
  });
  if (!text.empty()) return text;
  // M is that of no arm if it is not positive definite where the links lie along each other, forth or back.
  for (int folded = 0; folded < 1 << (n - 1); ++folded) {
    JointVector q = JointVector::Zero(n);
    for (int i = 1; i < n; ++i) q[i] = (folded >> (i - 1)) % 2 == 0 ? 0.0 : std::numbers::pi;
    if (affine(q, JointVector::Zero(n)).gain.allFinite()) continue;
    int link = 0;
    const auto own = [this](int i) { return of_link(mass, i) * of_link(com, i) * of_link(com, i); };
    for (int i = 1; i < n; ++i) {
      if (own(i) - of_link(inertia, i) > own(link) - of_link(inertia, link)) link = i;
    }
    return "no arm has these inertias: that of link " + std::to_string(link + 1) +
           " is about its joint, and so at least mass com^2 = " + format(own(link), 4);
  }
  return "";
}

// With the absolute angles A of the links the kinetic energy is sum_ij J_ij cos(A_i - A_j) A_i' A_j' / 2, where
// J_ij = l_i moment_j for i < j, and J_ii = I_i + l_i^2 sum_{k > i} m_k.
Affine PlanarArm::affine(const JointVector& q, const JointVector& v) const {
  const int n = joint_count();
  const JointVector angle = absolute(q), turning = absolute(v), moment = moments(*this);
  JointMatrix inertia_matrix(n, n);
  JointVector torque = JointVector::Zero(n);
  double beyond = 0.0;
  for (int i = n - 1; i >= 0; --i) {
    const double l = of_link(length, i);
    inertia_matrix(i, i) = of_link(inertia, i) + l * l * beyond;
    beyond += of_link(mass, i);
    for (int j = i + 1; j < n; ++j) {
      const double lever = l * moment[j], cosine = std::cos(angle[i] - angle[j]), sine = std::sin(angle[i] - angle[j]);
      inertia_matrix(i, j) = inertia_matrix(j, i) = lever * cosine;
      torque[i] -= lever * sine * turning[j] * turning[j];
      torque[j] += lever * sine * turning[i] * turning[i];
    }
  }
  // Along the joints: the sums over the links that each of them turns.
  for (int i = n - 2; i >= 0; --i) inertia_matrix.row(i) += inertia_matrix.row(i + 1);
  for (int j = n - 2; j >= 0; --j) inertia_matrix.col(j) += inertia_matrix.col(j + 1);
  torque = along_joints(torque) + gravity_torque(*this, moment, angle);
  for (int i = 0; i < n; ++i) {
    torque[i] -= of_link(friction, i) * v[i];
    inertia_matrix(i, i) += of_link(rotor_inertia, i);
  }
  const Eigen::LLT<JointMatrix> factor(inertia_matrix);
  if (factor.info() != Eigen::Success) {  // of no arm
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    return {JointVector::Constant(n, kNone), JointMatrix::Constant(n, n, kNone)};
  }
  const JointMatrix inverse = factor.solve(JointMatrix::Identity(n, n));
  return {factor.solve(torque), 0.5 * (inverse + inverse.transpose())};
}

JointVector PlanarArm::external_torque(const JointVector& q) const {
  return gravity_torque(*this, moments(*this), absolute(q));
}

}  // namespace bayesctrl
