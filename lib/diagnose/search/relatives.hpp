#pragma once

#include <string>
#include <vector>

#include "physics/effect.hpp"

namespace bayesctrl {

/// "coulomb_friction", in a machine of several joints "coulomb_friction@2".
std::string label(const Effect& effect, int joints);

/// Names of a set, sorted: what tells sets apart.
std::string key(const std::vector<Effect>& effects);

/// A set without one of its effects.
std::vector<Effect> without(std::vector<Effect> set, std::size_t effect);

/// Puts the simpler law of which a law is an extension in its place.
bool simplify(EffectForm& form);

/// Of each effect in turn: the set without it, and the set with its simpler law if it has one.
std::vector<std::vector<Effect>> simpler_sets(const std::vector<Effect>& effects);

/// A set that takes over the parameters of another where both hold the same effect.
std::vector<Effect> start_from(const std::vector<Effect>& known, std::vector<Effect> wanted);

/// Sets in which an effect has another law that reduces to the same simplest one (dry friction, drag), or such a second
/// one beside it: along a known motion these laws look so much alike that the screen cannot tell them apart.
std::vector<std::vector<Effect>> law_relatives(const std::vector<Effect>& set);

/// Sets in which an observationally equivalent effect stands in an effect's place, such as an offset of the sensor in
/// that of a tilt: on one plant or another the same motion is measured, and an answer has to say both.
std::vector<std::vector<Effect>> equivalents(const std::vector<Effect>& set);

/// Parameters for one set from those of another: a larger one, one with a simpler or richer law, or an equivalent.
/// Empty for all others.
std::vector<std::vector<Effect>> starts_from(const std::vector<Effect>& wanted, const std::vector<Effect>& other);

}  // namespace bayesctrl
