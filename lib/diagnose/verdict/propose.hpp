#pragma once

#include <nlohmann/json.hpp>

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// The next input, from a bounded family (rest, steps, chirp, slow reversals), under which the two best explanations
/// differ most: {input, separates, expected_log_odds}; null where one explanation stands alone.
nlohmann::ordered_json propose(const Plant& nominal, const Explanation& explanation, const std::vector<Measured>& data,
                               int joints);

}  // namespace bayesctrl
