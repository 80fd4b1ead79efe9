#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Sets that differ only in what does not matter are one: an effect, or what a law adds to a simpler one, without which
/// a set leaves hardly more of the nominal's error (`verdict.immaterial`) gives its probability to the set without it,
/// and so does dry friction that is no stronger at rest to its simpler law.
void merge_immaterial(Explanation& explanation);

/// Posterior probability that an effect is part of the machine, over all sets: "coulomb_friction@1" to probability.
std::map<std::string, double> inclusion(const Explanation& explanation);

/// The probability of all sets that hold one of these effects (labels), which the recordings cannot tell apart.
double inclusion_of_any(const Explanation& explanation, const std::vector<std::string>& names, int joints);

/// Of each effect of the best set: the part of the refit nominal's squared error beyond the noise, in free runs of
/// `horizon` seconds, that it takes away, which is what the others, adjusted anew, leave more without it. 0 to 1; sums
/// to 1 where effects do not interfere.
std::vector<double> shares(const Explanation& explanation, const std::vector<Measured>& data,
                           const ExplainOptions& options, double horizon);

}  // namespace bayesctrl
