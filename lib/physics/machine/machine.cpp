#include "physics/machine/machine.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

Machine::Machine(const Plant& plant, std::vector<Effect> effects, Remainder remainder)
    : plant_(plant),
      effects_(std::move(effects)),
      remainder_(std::move(remainder)),
      remainder_sum_(remainder_),
      joints_(bayesctrl::joints(plant_)),
      added_inertia_(JointSlots::Zero()),
      tilt_(JointSlots::Zero()),
      lag_(JointSlots::Zero()) {
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (DryFriction<E>) dry_[static_cast<std::size_t>(effect.joint)] = true;
          if constexpr (InertiaEffect<E>) added_inertia_[effect.joint] += form.added_inertia();
          if constexpr (TiltEffect<E>) tilt_[effect.joint] += form.tilt();
          if constexpr (LagEffect<E>) lag_[effect.joint] = form.lag();
          if constexpr (HiddenStateEffect<E>) has_hidden_states_ = true;
          if constexpr (TimedEffect<E>) switch_times_.push_back(form.switch_time());
          if constexpr (std::is_same_v<E, LoadDependentFriction>) bears_load_ = true;
        },
        effect.form);
  }
  has_added_inertia_ = added_inertia_.any();
  has_tilt_ = tilt_.any();
  std::sort(switch_times_.begin(), switch_times_.end());
}

std::vector<Drive> Machine::drives(const std::vector<double>& time, const Eigen::MatrixXd& input) const {
  std::vector<Drive> list;
  for (int j = 0; j < joints_; ++j) {
    list.emplace_back(time, std::vector<double>(input.col(j).begin(), input.col(j).end()), effects_, j);
  }
  return list;
}

JointVector Machine::measured(const JointVector& position) const {
  JointVector shown = position;
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (SensorEffect<E>) shown[effect.joint] = form.measured(shown[effect.joint]);
        },
        effect.form);
  }
  return shown;
}

JointVector Machine::decayed(const JointVector& lags, double by) const {
  JointVector left = JointVector::Zero(joints_);
  for (int j = 0; j < joints_; ++j) {
    if (lag_[j] > 0.0) left[j] = lags[j] * std::exp(-by / lag_[j]);
  }
  return left;
}

Eigen::MatrixXd Machine::hidden_states(const std::vector<double>& time, const Eigen::MatrixXd& velocity,
                                       const std::map<std::size_t, JointVector>& known) const {
  Eigen::MatrixXd z = Eigen::MatrixXd::Zero(velocity.rows(), joints_);
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (HiddenStateEffect<E>) {
            const int j = effect.joint;
            constexpr int kParts = 8;
            for (Eigen::Index k = 0; k + 1 < velocity.rows(); ++k) {
              const double h = (time[static_cast<std::size_t>(k) + 1] - time[static_cast<std::size_t>(k)]) / kParts;
              double at = z(k, j);
              for (int i = 0; i < kParts; ++i) {
                const double s = (i + 0.5) / kParts, v = (1.0 - s) * velocity(k, j) + s * velocity(k + 1, j);
                const double decay = form.settling_rate(v) * h;
                at += form.rate(v, at) * (decay < 1e-6 ? h : h * -std::expm1(-decay) / decay);
              }
              const auto given = known.find(static_cast<std::size_t>(k) + 1);
              z(k + 1, j) = given == known.end() ? at : given->second[j];
            }
          }
        },
        effect.form);
  }
  return z;
}

}  // namespace bayesctrl
