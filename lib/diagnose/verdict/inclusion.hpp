#pragma once

#include <map>
#include <string>
#include <vector>

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Sets that differ only in what does not matter are one. An effect, or what a law adds to a simpler one, without which
/// a set leaves hardly more (`verdict.immaterial` of the nominal's error, `verdict.unseen` of it where nothing else
/// is left), or which never acts, gives its probability to the set without it. Dry friction that is no stronger at
/// rest gives its own to the simpler law if it is ahead of it all the same; if not, the simpler law comes first.
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
