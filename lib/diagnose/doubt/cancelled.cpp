#include "diagnose/doubt/cancelled.hpp"

#include <algorithm>

#include "diagnose/doubt/kinematics.hpp"
#include "diagnose/settings.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

namespace {

constexpr double kLookedAt = 1000.0;  // samples

/// Squares of accelerations along a motion, of each joint: what was seen, what a model says of the velocity, and at
/// rest.
struct Terms {
  JointVector seen, of_speed, at_rest;
};

Terms terms_of(const Model& model, const Kinematics& seen) {
  const int n = joints(model.plant);
  Terms sum{JointVector::Zero(n), JointVector::Zero(n), JointVector::Zero(n)};
  double samples = 0.0;
  for (const Kinematics::Stretch& stretch : seen.stretches) samples += static_cast<double>(stretch.position.rows());
  const auto every = static_cast<Eigen::Index>(std::max(1.0, samples / kLookedAt));
  for (const Kinematics::Stretch& stretch : seen.stretches) {
    for (Eigen::Index k = 0; k < stretch.position.rows(); k += every) {
      const JointVector q = stretch.position.row(k), v = stretch.velocity.row(k);
      sum.seen += JointVector(stretch.acceleration.row(k)).cwiseAbs2();
      const JointVector at_rest = affine(model, q, JointVector::Zero(n)).drift;
      sum.of_speed += (affine(model, q, v).drift - at_rest).cwiseAbs2();
      sum.at_rest += at_rest.cwiseAbs2();
    }
  }
  return sum;
}

}  // namespace

std::optional<Cancelled> cancelled(const Fit& fit, const std::vector<Measured>& data) {
  if (fit.effects.empty()) return std::nullopt;
  const Kinematics seen = observe(data);
  const int n = joints(fit.plant);
  const Terms whole = terms_of({fit.plant}, seen);
  std::vector<std::vector<Effect>> sets{fit.effects};
  if (fit.effects.size() > 1) {
    for (const Effect& effect : fit.effects) sets.push_back({effect});
  }
  for (const std::vector<Effect>& effects : sets) {
    const Terms left = terms_of({fit.plant, effects}, seen);
    for (int j = 0; j < n; ++j) {
      const auto undone = [&](const JointVector& before, const JointVector& after) {
        return before[j] > kSettings.doubt.matters * whole.seen[j] && after[j] < kSettings.doubt.undone * before[j];
      };
      if (undone(whole.of_speed, left.of_speed)) return Cancelled{j, true};
      if (undone(whole.at_rest, left.at_rest)) return Cancelled{j, false};
    }
  }
  return std::nullopt;
}

}  // namespace bayesctrl
