#include "physics/machine/machine.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace bayesctrl {

Machine::Machine(const Plant& plant, std::vector<Effect> effects, Remainder remainder, RecordedTemperature temperature)
    : plant_(plant),
      effects_(std::move(effects)),
      remainder_(std::move(remainder)),
      remainder_sum_(remainder_),
      joints_(bayesctrl::joints(plant_)),
      added_inertia_(JointSlots::Zero()),
      tilt_(JointSlots::Zero()),
      lag_(JointSlots::Zero()),
      reach_(JointSlots::Zero()) {
  for (const Effect& effect : effects_) {
    const EffectForm& form = effect.form;
    const EffectRoles& roles = form.roles();
    if (roles.dry_friction) dry_[static_cast<std::size_t>(effect.joint)] = true;
    if (roles.lag) lag_[effect.joint] = form.lag();
    if (roles.timed) switch_times_.push_back(form.switch_time());
    if (roles.contact) contacts_.push_back(slots_.size());
    added_inertia_[effect.joint] += form.added_inertia();
    tilt_[effect.joint] += form.tilt();
    if (roles.play) reach_[effect.joint] = form.follow(0.0, kInfinity);
    has_delay_ |= roles.delay;
    bears_load_ |= roles.feels_load;
    load_drives_hidden_ |= roles.feels_load && roles.hidden_state;
    hidden_settle_ &= !roles.hidden_state || roles.settles;
    slots_.push_back(hidden_count_);
    hidden_count_ += form.law().hidden_count;
  }
  if (hidden_count_ > kMaxHidden) throw std::invalid_argument("more hidden states than a machine may have");
  if (feel_temperature(effects_)) temperature_ = std::move(temperature);
  has_added_inertia_ = added_inertia_.any();
  has_tilt_ = tilt_.any();
  std::sort(switch_times_.begin(), switch_times_.end());
}

std::vector<Drive> Machine::drives(const std::vector<double>& time, const Eigen::MatrixXd& input, const FineInput* fine,
                                   const Restarts& restarts) const {
  std::vector<Drive> list;
  for (int j = 0; j < joints_; ++j) {
    list.emplace_back(time, std::vector<double>(input.col(j).begin(), input.col(j).end()), effects_, j, fine, restarts);
  }
  return list;
}

JointVector Machine::measured(const JointVector& position) const {
  JointVector shown = position;
  for (const Effect& effect : effects_) {
    shown[effect.joint] = effect.form.measured(shown[effect.joint]);
  }
  return shown;
}

}  // namespace bayesctrl
