#pragma once

#include "diagnose/recording/spec.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "physics/effect.hpp"

namespace bayesctrl {

/// Units of every joint's numbers: as the signals state them, else as the plant has them. What a slide (position in m)
/// gets from effects is a force; a custom machine without inertia gets accelerations, one with inertia of neither an
/// angle nor a length the unit of its input.
std::vector<JointUnits> joint_units(const DiagnosisSpec& spec);

/// Unit of an effect's parameter in a joint: effects declare theirs for a rotary joint, "N m s/rad" becomes "N s/m".
std::string unit_of(const EffectForm& form, std::string_view parameter, const JointUnits& units);

/// Unit of a nominal parameter: a `mass` that turns is a rotor.
std::string unit_of(const Plant& plant, std::string_view parameter, const JointUnits& units);

}  // namespace bayesctrl
