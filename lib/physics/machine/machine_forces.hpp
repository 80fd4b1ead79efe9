#pragma once

// What moves a machine: accelerations at one state, and the torques that hold joints at rest.

#include <Eigen/LU>
#include <cmath>

#include "physics/machine/machine_state.hpp"

namespace bayesctrl {

/// On the joints' bearings: torque of the motors, and of gravity and springs.
template <int kJoints>
struct Machine::Load {
  Joints<kJoints> motor = Joints<kJoints>::Zero(), external = motor, unsteady = motor;
};

/// `driven`: what the plant does with this input.
template <int kJoints>
Machine::Load<kJoints> Machine::load(const StateOf<kJoints>& state, const Joints<kJoints>& input, double t,
                                     const MotionOf<kJoints>& driven) const {
  Load<kJoints> result;
  result.motor = input;
  result.external = external_torque_of<kJoints>(plant_, state.q + tilt_.head<kJoints>());
  for (int j = 0; j < kJoints; ++j) result.external[j] += spring_torque(effects_, j, state.q[j]);
  if (std::holds_alternative<Custom>(plant_)) {  // the input is no torque: what it adds to M q'' is
    const MotionOf<kJoints> idle = motion_of<kJoints>(plant_, state.q, state.v, Joints<kJoints>::Zero(), t);
    result.motor = inverse_dynamics<kJoints>(driven.mobility, driven.acceleration - idle.acceleration);
  }
  return result;
}

/// The same, with what the input does besides what is held of it.
template <int kJoints>
Machine::Load<kJoints> Machine::load_at(const Moment& moment, const StateOf<kJoints>& state,
                                        const Joints<kJoints>& input, double t, const MotionOf<kJoints>& driven) const {
  Load<kJoints> result = load<kJoints>(state, input, t, driven);
  const bool custom = std::holds_alternative<Custom>(plant_);
  for (int j = 0; j < kJoints && (!custom || kJoints == 1); ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const Drive& drive = (*moment.drives)[slot];
    if (!drive.has_spread()) continue;
    double gain = 1.0;
    if (custom) {
      const MotionOf<kJoints> more = motion_of<kJoints>(plant_, state.q, state.v, input + Joints<kJoints>::Ones(), t);
      gain = inverse_dynamics<kJoints>(driven.mobility, more.acceleration - driven.acceleration)[0];
      if (gain == 0.0) continue;
    }
    result.unsteady[j] = std::abs(gain) * drive.unsteady(moment.segment[slot], result.external[j] / gain);
  }
  return result;
}

/// What the plant does with this input, where the load asks for it.
template <int kJoints>
MotionOf<kJoints> Machine::driven_by(const StateOf<kJoints>& state, const Joints<kJoints>& input, double t) const {
  if (!std::holds_alternative<Custom>(plant_)) return {};
  return motion_of<kJoints>(plant_, state.q, state.v, input, t);
}

/// What the effects of one joint look at.
template <int kJoints>
JointState Machine::seen(int joint, const StateOf<kJoints>& state, double t, const Load<kJoints>& on_bearings) const {
  return {state.q[joint],
          state.v[joint],
          t,
          on_bearings.motor[joint],
          on_bearings.external[joint],
          state.q[neighbour_of(joint, kJoints)],
          0.0,
          temperature_ ? temperature_->at(joint, t) : kReferenceTemperature,
          on_bearings.unsteady[joint]};
}

/// The load, where a hidden state asks for it.
template <int kJoints>
Machine::Load<kJoints> Machine::load_on_hidden(const StateOf<kJoints>& state, const Joints<kJoints>& input,
                                               double t) const {
  if (!load_drives_hidden_) return {};
  return load<kJoints>(state, input, t, driven_by<kJoints>(state, input, t));
}

/// The hidden states `begin` after `by` seconds in which the machine drives them as it does `at` a state.
template <int kJoints>
HiddenVector Machine::follow(const HiddenVector& begin, const StateOf<kJoints>& at, const Joints<kJoints>& input,
                             double t, double by, HiddenVector* rates) const {
  HiddenVector next = begin;
  if (hidden_count_ == 0) return next;
  const Load<kJoints> on_bearings = load_on_hidden<kJoints>(at, input, t);
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    if (!effects_[e].form.roles().hidden_state) continue;
    const JointState joint = seen<kJoints>(effects_[e].joint, at, t, on_bearings);
    follow_one(effects_[e].form, slots_[e], joint, begin, at.z, by, *rates, next);
  }
  return next;
}

/// Hidden states after h seconds in which all else is constant.
template <int kJoints>
void Machine::settle_along(StateOf<kJoints>& state, const Joints<kJoints>& input, double t, double h) const {
  const Load<kJoints> on_bearings = load_on_hidden<kJoints>(state, input, t);
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const EffectForm& form = effects_[e].form;
    if (!form.roles().hidden_state) continue;
    form.settle(part_of(state.z, form, slots_[e]), seen<kJoints>(effects_[e].joint, state, t, on_bearings), h);
  }
}

/// Inputs of all joints at time t.
template <int kJoints>
Joints<kJoints> Machine::input_at(const Moment& moment, double t) const {
  Joints<kJoints> input;
  for (int j = 0; j < kJoints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    input[j] = (*moment.drives)[slot].at(moment.segment[slot], t);
    if (moment.departure[j] != 0.0) input[j] += moment.departure[j] * std::exp(-(t - moment.begin) / lag_[j]);
  }
  return input;
}

/// Inputs of all joints over one step: lines, in its middle and by how much they differ there from its ends.
template <int kJoints>
struct Machine::InputOver {
  Joints<kJoints> middle, half_rise;
};

/// Over [moment.t, moment.t + h], with the mean and the first moment of what acts: a mass that it moves is where it
/// would be, at the end of a step that need not resolve the lags.
template <int kJoints>
Machine::InputOver<kJoints> Machine::input_over(const Moment& moment, double h) const {
  InputOver<kJoints> input;
  for (int j = 0; j < kJoints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    Line line = (*moment.drives)[slot].over(moment.segment[slot], moment.t, h);
    if (moment.departure[j] != 0.0) {
      const double left = moment.departure[j] * std::exp(-(moment.t - moment.begin) / lag_[j]);
      const Line departed = decaying(left, lag_[j], h);
      line.middle += departed.middle;
      line.slope += departed.slope;
    }
    input.middle[j] = line.middle;
    input.half_rise[j] = 0.5 * h * line.slope;
  }
  return input;
}

/// q'' at one state. Joints that are stuck do not accelerate; the torques that hold them go to `holding_torque`.
template <int kJoints>
Joints<kJoints> Machine::acceleration(const StateOf<kJoints>& state, const Joints<kJoints>& input, const Moment& moment,
                                      double t, Joints<kJoints>* holding_torque) const {
  const Joints<kJoints>&q = state.q, &v = state.v;
  MotionOf<kJoints> nominal = motion_of<kJoints>(plant_, q, v, input, t);
  Joints<kJoints> torque = Joints<kJoints>::Zero(), friction = torque;
  if (has_tilt_) {
    torque = external_torque_of<kJoints>(plant_, q + tilt_.head<kJoints>()) - external_torque_of<kJoints>(plant_, q);
  }
  const Load<kJoints> on_bearings = bears_load_ ? load_at<kJoints>(moment, state, input, t, nominal) : Load<kJoints>{};
  if (!remainder_sum_.empty()) {
    torque += Joints<kJoints>(remainder_sum_.torque(moment.memory, q, v, input, t));
  }
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const int j = effects_[e].joint;
    const JointState here = seen<kJoints>(j, state, t, on_bearings);
    const EffectForm& form = effects_[e].form;
    const EffectRoles& roles = form.roles();
    if (roles.timed) {  // steps end at its switch: what holds at their beginning holds throughout
      torque[j] += form.torque_at({.time = moment.t});
    } else if (roles.torque && (!roles.contact || moment.touches(e))) {
      torque[j] += form.torque_at(here);
    }
    if (roles.dry_friction) friction[j] += form.sliding(here);
    if (roles.hidden_state) torque[j] += form.torque_of(part_of(state.z, form, slots_[e]), here);
  }
  for (int j = 0; j < kJoints; ++j) torque[j] -= moment.direction[static_cast<std::size_t>(j)] * friction[j];

  // (M + D) q'' = M nominal + torques, D the added inertia and M^-1 the mobility: q'' = (1 + M^-1 D)^-1 (...).
  JointsSquare<kJoints>& mobility = nominal.mobility;
  Joints<kJoints> result = moved_by<kJoints>(nominal.acceleration, mobility, torque);
  if (has_added_inertia_) {
    const JointsSquare<kJoints> more = mobility * added_inertia_.head<kJoints>().asDiagonal();
    const JointsSquare<kJoints> inverse = (JointsSquare<kJoints>::Identity() + more).inverse();
    mobility = (inverse * mobility).eval();
    result = (inverse * result).eval();
  }

  // The torques f that keep the stuck joints S at rest: mobility_SS f_S = -q''_S.
  const auto stuck = [&](int j) {
    const auto slot = static_cast<std::size_t>(j);
    return dry_[slot] && moment.direction[slot] == 0;
  };
  Joints<kJoints> held = Joints<kJoints>::Zero();
  bool any = false;
  for (int j = 0; j < kJoints; ++j) any |= stuck(j);
  if (any) {
    JointsSquare<kJoints> system = JointsSquare<kJoints>::Identity();
    for (int i = 0; i < kJoints; ++i) {
      if (!stuck(i)) continue;
      held[i] = -result[i];
      for (int j = 0; j < kJoints; ++j) {
        if (stuck(j)) system(i, j) = mobility(i, j);
      }
    }
    held = inverse_dynamics<kJoints>(system, held);
    result = moved_by<kJoints>(result, mobility, held);
    for (int j = 0; j < kJoints; ++j) {
      if (stuck(j)) result[j] = 0.0;
    }
  }
  if (holding_torque != nullptr) *holding_torque = held;
  return result;
}

template <int kJoints>
double Machine::holding(const StateOf<kJoints>& state, const Moment& moment, int joint) const {
  Load<kJoints> on_bearings;
  if (bears_load_) {
    const Joints<kJoints> input = input_at<kJoints>(moment, moment.t);
    on_bearings = load_at<kJoints>(moment, state, input, moment.t, driven_by<kJoints>(state, input, moment.t));
  }
  JointState here = seen<kJoints>(joint, state, moment.t, on_bearings);
  here.velocity = 0.0;
  double level = 0.0;
  for (const Effect& effect : effects_) {
    if (effect.joint == joint && effect.form.roles().dry_friction) level += effect.form.holding(here);
  }
  return level;
}

}  // namespace bayesctrl
