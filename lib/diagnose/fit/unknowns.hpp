#pragma once

#include <algorithm>

#include "diagnose/motion/forcing.hpp"

namespace bayesctrl {

/// One number that a fit adjusts: a parameter of an effect or, with effect -1, a free parameter of the plant.
struct Unknown {
  int effect = -1;
  std::string name;
  double value = 0.0;
  double low = -kInfinity, high = kInfinity;
  double prior_mean = 0.0, prior_deviation = 1.0;
  double step = 1e-3;            // of differences
  double least_deviation = 0.0;  // of a prior that is as wide as its parameter turns out to need; 0: of one that is not

  /// Where differences are taken.
  double above() const { return std::min(value + step, high); }
  double below() const { return std::max(value - step, low); }
};

/// What a fit adjusts: `free` parameters of the plant, about those of `given`, then all of the effects, with their
/// bounds, priors and steps as the effects declare them. A prior deviation of 0 is one that follows from what the
/// parameter does: `complete_priors` settles it.
std::vector<Unknown> list_unknowns(const Plant& plant, const Plant& given, const std::vector<Effect>& effects,
                                   const std::vector<std::string>& free, const std::vector<Measured>& data,
                                   const std::vector<Trajectory>& paths);

/// Priors that follow from other parameters of the same effect, from these as they now are; and how wide those of a
/// scale that nobody knows have to be: the likeliest deviation for the value, at least `least_deviation`. Strong
/// physics is then as credible as weak: the price of a value grows with its logarithm, not with its square.
void renew_priors(std::vector<Unknown>& unknowns, const std::vector<Effect>& effects);

}  // namespace bayesctrl
