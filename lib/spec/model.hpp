#pragma once

#include <nlohmann/json.hpp>

#include "io/node.hpp"
#include "io/schema.hpp"
#include "physics/model.hpp"

namespace bayesctrl {

/// The notation of a model in every spec: `plant: NAME` and `parameters: {...}` side by side. These are the hooks that
/// io/read.hpp, io/emit.hpp and io/schema.hpp look for.
void read_value(const Node& node, Model& model);
nlohmann::ordered_json json_value(const Model& model);
nlohmann::ordered_json schema_value(const Model*, detail::Definitions& definitions);

/// The schema of a model spelt out, one choice per plant under `oneOf`: for notations that add keys to it.
nlohmann::ordered_json model_schema(detail::Definitions& definitions);

}  // namespace bayesctrl
