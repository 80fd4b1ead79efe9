#include "physics/model.hpp"

#include "numerics/dense.hpp"

namespace bayesctrl {

std::string ModelUncertainty::problem(int joints) const {
  const auto fits = [joints](const std::vector<double>& list) {
    return list.size() == 1 || static_cast<int>(list.size()) == joints;
  };
  const std::string one_for_each = joints == 1 ? " one number" : " one number for all joints or one for each";
  if (!fits(drift)) return "drift has" + one_for_each;
  if (!fits(input_gain)) return "input_gain has" + one_for_each;
  return joints == 1 || coupling.empty() || fits(coupling) ? "" : "coupling has" + one_for_each;
}

Affine affine(const Model& model, const JointVector& q, const JointVector& v, const JointVector& celsius) {
  Affine result = affine(model.plant, q, v);
  if (model.is_plain()) return result;
  const Eigen::Index n = q.size();
  const JointVector none = JointVector::Zero(n);
  const JointMatrix mobility = motion(model.plant, q, v, none, 0.0).mobility;
  JointVector torque = none, tilt = none, inertia = none;
  for (const Effect& effect : model.effects) tilt[effect.joint] += effect.form.tilt();
  const JointVector gravity = external_torque(model.plant, q + tilt);
  if (tilt.any()) torque += gravity - external_torque(model.plant, q);
  JointVector external = gravity;
  for (Eigen::Index j = 0; j < n; ++j) external[j] += spring_torque(model.effects, static_cast<int>(j), q[j]);
  for (const Effect& effect : model.effects) {
    const Eigen::Index j = effect.joint;
    JointState state{q[j], v[j],        0.0,
                     0.0,  external[j], q[neighbour_of(static_cast<int>(j), static_cast<int>(q.size()))]};
    if (celsius.size() > 0) state.temperature = celsius[j];
    const EffectForm& form = effect.form;
    if (form.roles().of_time) continue;
    torque[j] += form.torque_at(state) - form.sliding(state) * (v[j] > 0.0 ? 1.0 : v[j] < 0.0 ? -1.0 : 0.0);
    inertia[j] += form.added_inertia();
    result.gain.col(j) *= form.slope();
  }
  if (!model.remainder.empty()) {
    torque += model.remainder.torque(model.remainder.begin(q, v), q, v, none, 0.0);
  }
  result.drift += mobility * torque;
  if (inertia.any()) {
    const JointMatrix system = JointMatrix::Identity(n, n) + mobility * inertia.asDiagonal();
    const JointSolver solver(system);
    result.drift = solver.solve(result.drift);
    result.gain = solver.solve(result.gain);
  }
  return result;
}

}  // namespace bayesctrl
