#pragma once

#include <nlohmann/json.hpp>

#include "io/node.hpp"
#include "io/schema.hpp"
#include "physics/discrepancy/remainder.hpp"

namespace bayesctrl {

/// The notation of a remainder: {regions: [...], terms: [{type, joint, parameters..., weight}, ...]}; joints count from
/// 1. Terms in the older notation (spec/older_terms.hpp) are read as well.
Remainder read_remainder(const Node& node, int joint_count);
nlohmann::ordered_json remainder_json(const Remainder& remainder);
nlohmann::ordered_json remainder_schema(detail::Definitions& definitions);

}  // namespace bayesctrl
