#pragma once

#include <tuple>

#include "physics/effects/actuator_lag.hpp"
#include "physics/effects/added_inertia.hpp"
#include "physics/effects/asymmetric_friction.hpp"
#include "physics/effects/backlash.hpp"
#include "physics/effects/cogging_torque.hpp"
#include "physics/effects/constant_bias.hpp"
#include "physics/effects/coulomb_friction.hpp"
#include "physics/effects/counterbalance.hpp"
#include "physics/effects/coupling_torque.hpp"
#include "physics/effects/cubic_spring.hpp"
#include "physics/effects/elastic_load.hpp"
#include "physics/effects/gravity_tilt.hpp"
#include "physics/effects/hard_stop.hpp"
#include "physics/effects/input_dead_zone.hpp"
#include "physics/effects/input_delay.hpp"
#include "physics/effects/input_gain.hpp"
#include "physics/effects/input_saturation.hpp"
#include "physics/effects/joint_elasticity.hpp"
#include "physics/effects/linear_spring.hpp"
#include "physics/effects/load_dependent_friction.hpp"
#include "physics/effects/load_stribeck_friction.hpp"
#include "physics/effects/periodic_disturbance.hpp"
#include "physics/effects/position_dependent_friction.hpp"
#include "physics/effects/presliding_hysteresis.hpp"
#include "physics/effects/quadratic_drag.hpp"
#include "physics/effects/recording_gain.hpp"
#include "physics/effects/recording_offset.hpp"
#include "physics/effects/sensor_offset.hpp"
#include "physics/effects/sensor_scale.hpp"
#include "physics/effects/stribeck_friction.hpp"
#include "physics/effects/thermal_friction.hpp"
#include "physics/effects/torque_step.hpp"
#include "physics/effects/viscous_friction.hpp"
#include "physics/effects/warming_friction.hpp"

namespace bayesctrl {

/// The catalogue of additional physics. A new effect is one file in effects/ and one line here. Input effects apply in
/// this order.
using Catalogue =
    std::tuple<ViscousFriction, CoulombFriction, StribeckFriction, QuadraticDrag, AsymmetricFriction,
               PositionDependentFriction, LoadDependentFriction, LinearSpring, CubicSpring, CouplingTorque,
               ConstantBias, GravityTilt, CoggingTorque, HardStop, PeriodicDisturbance, TorqueStep, AddedInertia,
               InputDelay, InputGain, RecordingGain, InputDeadZone, Backlash, InputSaturation, ActuatorLag,
               PreslidingHysteresis, SensorOffset, SensorScale, JointElasticity, ElasticLoad, Counterbalance,
               WarmingFriction, LoadStribeckFriction, ThermalFriction, RecordingOffset>;

/// Calls f(E{}) for the type E of each effect.
void for_each_effect(auto&& f) {
  [&]<class... E>(const std::tuple<E...>*) { (f(E{}), ...); }(static_cast<const Catalogue*>(nullptr));
}

}  // namespace bayesctrl
