#include "physics/machine/machine.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

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
          if constexpr (TimedEffect<E>) switch_times_.push_back(form.switch_time());
          if constexpr (LoadedEffect<E>) {
            bears_load_ = true;
            if constexpr (HiddenStateEffect<E>) load_drives_hidden_ = true;
          }
        },
        effect.form);
    slots_.push_back(hidden_count_);
    hidden_count_ += bayesctrl::hidden_count(effect.form);
  }
  if (hidden_count_ > kMaxHidden) throw std::invalid_argument("more hidden states than a machine may have");
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

}  // namespace bayesctrl
