#pragma once

#include <functional>
#include <vector>

#include "base/random.hpp"
#include "physics/effect.hpp"
#include "physics/plant.hpp"

namespace bayesctrl::trial {

double log_uniform(RandomStream& random, double low, double high);

/// A machine of drawn parameters; `variant` says which plant.
Plant draw_plant(int variant, RandomStream& random);

/// Viscous friction that the nominal has.
double friction_of(const Plant& plant, int joint);

/// Whether the recordings of such a machine can show such an effect at all.
bool applies(std::size_t kind, const Plant& plant);

/// Of a linear machine nobody can tell an effect from its equivalent.
bool can_be_told_apart(const std::vector<Effect>& effects, const Plant& plant);

/// Strength that gives a size, by bisection in its logarithm; 0 where there is none.
double strength_for(double target, const std::function<double(double)>& size);

}  // namespace bayesctrl::trial
