#pragma once

#include <concepts>
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

/// A torque from a state z of its own, z' = rate(v, z), which settles at `settling_rate`.
template <class E>
concept HiddenStateEffect = requires(const E& e, double v, double z) {
  { e.rate(v, z) } -> std::same_as<double>;
  { e.settling_rate(v) } -> std::same_as<double>;
  { e.torque_of(z) } -> std::same_as<double>;
};

/// A torque that jumps at a time, at which integration steps must end.
template <class E>
concept TimedEffect = requires(const E& e) {
  { e.switch_time() } -> std::same_as<double>;
};

/// A torque that the joint's bearings carry: part of the load on them.
template <class E>
concept SpringEffect = TorqueEffect<E> && E::kSpring;

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

/// What the sensor shows instead of the position.
template <class E>
concept SensorEffect = requires(const E& e, double q) {
  { e.measured(q) } -> std::same_as<double>;
};

/// The same law in the same place, whatever its parameters.
bool same_kind(const Effect& a, const Effect& b);

/// Torque of the springs among the effects of one joint at a position of it.
double spring_torque(const std::vector<Effect>& effects, int joint, double position);

/// Whether a set holds a law twice, or beside one that contains it, in the same joint: together they are no other law
/// than the second alone.
bool redundant(const std::vector<Effect>& effects);

/// The side of the machine on which an effect acts: "drift", "input" or "sensor".
std::string_view channel(const EffectForm& form);

}  // namespace bayesctrl
