#pragma once

#include "physics/plant.hpp"

namespace bayesctrl {

/// A simulated machine: nominal mechanics. In specs: `plant: NAME` and `parameters: {...}`.
struct Model {
  static constexpr std::string_view kName = "model";
  Plant plant;

  bool operator==(const Model&) const = default;
};

}  // namespace bayesctrl
