#pragma once

#include "diagnose/search/explain.hpp"
#include "diagnose/verdict/diagnosis.hpp"

namespace bayesctrl {

/// The next input, from a bounded family (rest, steps, chirp, slow reversals), under which the two best explanations
/// differ most; nothing where one explanation stands alone.
std::optional<NextExperiment> propose(const Plant& nominal, const Explanation& explanation,
                                      const std::vector<Measured>& data, const std::vector<JointUnits>& units);

}  // namespace bayesctrl
