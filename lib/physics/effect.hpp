#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "physics/effects/actuator_lag.hpp"
#include "physics/effects/added_inertia.hpp"
#include "physics/effects/asymmetric_friction.hpp"
#include "physics/effects/backlash.hpp"
#include "physics/effects/cogging_torque.hpp"
#include "physics/effects/constant_bias.hpp"
#include "physics/effects/coulomb_friction.hpp"
#include "physics/effects/coupling_torque.hpp"
#include "physics/effects/cubic_spring.hpp"
#include "physics/effects/gravity_tilt.hpp"
#include "physics/effects/hard_stop.hpp"
#include "physics/effects/input_dead_zone.hpp"
#include "physics/effects/input_delay.hpp"
#include "physics/effects/input_gain.hpp"
#include "physics/effects/input_saturation.hpp"
#include "physics/effects/linear_spring.hpp"
#include "physics/effects/load_dependent_friction.hpp"
#include "physics/effects/periodic_disturbance.hpp"
#include "physics/effects/position_dependent_friction.hpp"
#include "physics/effects/presliding_hysteresis.hpp"
#include "physics/effects/quadratic_drag.hpp"
#include "physics/effects/sensor_offset.hpp"
#include "physics/effects/sensor_scale.hpp"
#include "physics/effects/stribeck_friction.hpp"
#include "physics/effects/torque_step.hpp"
#include "physics/effects/viscous_friction.hpp"

namespace bayesctrl {

/// The catalogue of additional physics. A new effect is one file in effects/ and one line here. Input effects apply in
/// this order; the kinds below tell how an effect acts.
using EffectForm = std::variant<ViscousFriction, CoulombFriction, StribeckFriction, QuadraticDrag, AsymmetricFriction,
                                PositionDependentFriction, LoadDependentFriction, LinearSpring, CubicSpring,
                                CouplingTorque, ConstantBias, GravityTilt, CoggingTorque, HardStop, PeriodicDisturbance,
                                TorqueStep, AddedInertia, InputDelay, InputGain, InputDeadZone, Backlash,
                                InputSaturation, ActuatorLag, PreslidingHysteresis, SensorOffset, SensorScale>;

/// One effect in one joint (counted from 0; files and reports count from 1).
struct Effect {
  EffectForm form;
  int joint = 0;
  int recording = -1;  // the only recording in which it acts, counted from 0; -1: every one

  bool operator==(const Effect&) const = default;
};

/// A torque that is a function of the joint's state.
template <class E>
concept TorqueEffect = requires(const E& e, const JointState& s) {
  { e.torque_at(s) } -> std::same_as<double>;
};

/// Dry friction: `sliding` is its magnitude in motion, `holding` the largest torque that it resists at rest.
template <class E>
concept DryFriction = requires(const E& e, const JointState& s) {
  { e.sliding(s) } -> std::same_as<double>;
  { e.holding(s) } -> std::same_as<double>;
};

/// A torque from a state z of its own, any HiddenState: z' = rate(z, joint), the fastest part of which settles at
/// `settling_rate`. Steps of the integration resolve that rate. Optional: `settled(z, joint, h)`, exact after h seconds
/// in which the joint's state is constant; `is_steady(z, joint)`, when longer steps will do.
template <class E>
concept HiddenStateEffect = requires(const E& e, const JointState& s, const typename E::State& z) {
  { e.rate(z, s) } -> std::same_as<typename E::State>;
  { e.settling_rate(s) } -> std::same_as<double>;
  { e.torque_of(z, s) } -> std::same_as<double>;
};
template <class E>
concept SolvedStateEffect = HiddenStateEffect<E> && requires(const E& e, const JointState& s, typename E::State z) {
  { e.settled(z, s, 1.0) } -> std::same_as<typename E::State>;
};

/// How many numbers the hidden state of an effect is.
template <class E>
constexpr int hidden_count() {
  if constexpr (HiddenStateEffect<E>) return static_cast<int>(std::tuple_size_v<typename E::State>);
  return 0;
}

/// A torque that jumps at a time, at which integration steps must end; `kJump` names the parameter by how much.
template <class E>
concept TimedEffect = requires(const E& e) {
  { e.switch_time() } -> std::same_as<double>;
  E::kJump;
};

/// A torque that is no function of the machine's state.
template <class E>
concept TimeEffect = TorqueEffect<E> && E::kOfTime;

/// A torque that the joint's bearings carry: part of the load on them.
template <class E>
concept SpringEffect = TorqueEffect<E> && E::kSpring;

/// It reads the load on the bearings: JointState's motor_torque and external_torque.
template <class E>
concept LoadedEffect = E::kFeelsLoad;

template <class E>
concept TiltEffect = requires(const E& e) {
  { e.tilt() } -> std::same_as<double>;
};
template <class E>
concept InertiaEffect = requires(const E& e) {
  { e.added_inertia() } -> std::same_as<double>;
};

/// Input effects: a late input, a static map, a play, a first-order lag.
template <class E>
concept DelayEffect = requires(const E& e) {
  { e.delay_time() } -> std::same_as<double>;
};
template <class E>
concept MapEffect = requires(const E& e, double u) {
  { e.transform(u) } -> std::same_as<double>;
};
template <class E>
concept PlayEffect = requires(const E& e, double u) {
  { e.follow(u, u) } -> std::same_as<double>;
};
template <class E>
concept LagEffect = requires(const E& e) {
  { e.lag() } -> std::same_as<double>;
};

/// A map of the input that multiplies it.
template <class E>
concept GainEffect = MapEffect<E> && requires(const E& e) {
  { e.slope() } -> std::same_as<double>;
};

/// What the sensor shows instead of the position.
template <class E>
concept SensorEffect = requires(const E& e, double q) {
  { e.measured(q) } -> std::same_as<double>;
};

/// How an effect acts: each is of one kind at least.
template <class E>
inline constexpr int kRoles =
    TorqueEffect<E> + DryFriction<E> + HiddenStateEffect<E> + InertiaEffect<E> + TiltEffect<E> + DelayEffect<E> +
    MapEffect<E> + PlayEffect<E> + LagEffect<E> + SensorEffect<E>;
template <class... E>
constexpr bool have_roles(const std::variant<E...>*) {
  return ((kRoles<E> > 0) && ...);
}
static_assert(have_roles(static_cast<const EffectForm*>(nullptr)), "an effect that nothing would ever ask for");

/// The side of the machine on which an effect acts.
template <class E>
constexpr std::string_view channel_of() {
  if (SensorEffect<E>) return "sensor";
  return DelayEffect<E> || MapEffect<E> || PlayEffect<E> || LagEffect<E> ? "input" : "drift";
}

/// Hidden state after h seconds in which the joint's state is constant.
template <HiddenStateEffect E>
typename E::State settled(const E& effect, const typename E::State& z, const JointState& joint, double h) {
  if constexpr (SolvedStateEffect<E>) {
    return effect.settled(z, joint, h);
  } else {
    constexpr double kPart = 0.5, kMost = 1000.0;  // of the time in which it settles; steps
    const int steps = static_cast<int>(std::clamp(std::ceil(h * effect.settling_rate(joint) / kPart), 1.0, kMost));
    const double by = h / steps;
    typename E::State now = z;
    for (int i = 0; i < steps; ++i) {
      const typename E::State k1 = effect.rate(now, joint), k2 = effect.rate(moved(now, k1, 0.5 * by), joint);
      const typename E::State k3 = effect.rate(moved(now, k2, 0.5 * by), joint);
      now = moved(now, mean_rate(k1, k2, k3, effect.rate(moved(now, k3, by), joint)), by);
    }
    return now;
  }
}

/// The effect of one type drawn for a machine. `uniform(low, high)` draws a number; all that an effect needs are drawn
/// in the order of its declaration, the recording of a timed one (of the first three) last.
template <class E>
std::pair<E, int> drawn_with_recording(auto&& uniform, const DrawScales& scales) {
  const E form = E::drawn(uniform, scales);
  if constexpr (TimedEffect<E>) return {form, static_cast<int>(uniform(0.0, 2.999))};
  return {form, -1};
}

/// The same law in the same place, whatever its parameters.
bool same_kind(const Effect& a, const Effect& b);

/// Torque of the springs among the effects of one joint at a position of it.
double spring_torque(const std::vector<Effect>& effects, int joint, double position);

/// Whether a set holds a law twice, or beside one that contains it, in the same joint: together they are no other law
/// than the second alone.
bool redundant(const std::vector<Effect>& effects);

/// The effect that shows the same on one plant or another. A fit brings it into its range.
std::optional<EffectForm> equivalent(const EffectForm& form);

/// Joints that a machine must have for an effect to act in it.
int least_joints(const EffectForm& form);

/// Numbers of the hidden states of effects: those of each follow on those of the one before.
int hidden_count(const EffectForm& form);
int hidden_count(const std::vector<Effect>& effects);

/// The side of the machine on which an effect acts: "drift", "input" or "sensor".
std::string_view channel(const EffectForm& form);

}  // namespace bayesctrl
