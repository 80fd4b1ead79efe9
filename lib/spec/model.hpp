#pragma once

#include <nlohmann/json.hpp>

#include "io/node.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// The notation of a model in every spec: `plant: NAME` and `parameters: {...}` side by side. These are the hooks that
/// io/read.hpp, io/emit.hpp and io/schema.hpp look for.
void read_value(const Node& node, Model& model);
nlohmann::ordered_json json_value(const Model& model);
nlohmann::ordered_json schema_value(const Model*);

}  // namespace bayesctrl
