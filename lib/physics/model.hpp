#pragma once

#include <vector>

#include "physics/discrepancy/remainder.hpp"
#include "physics/effect.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// A simulated machine: nominal mechanics, physics beside it, and a torque that no physics explains. In specs:
/// `plant: NAME`, `parameters: {...}`, `effects: [...]`, `remainder: {...}`, or `file: model.yaml`.
struct Model {
  static constexpr std::string_view kName = "model";
  Plant plant;
  std::vector<Effect> effects = {};
  Remainder remainder = {};

  bool is_plain() const { return effects.empty() && remainder.empty(); }
  bool operator==(const Model&) const = default;
};

/// q'' = a + b u as far as it is a function of the state: effects with a memory, in time or in the sensor are left out,
/// dry friction acts along the velocity.
Affine affine(const Model& model, const JointVector& q, const JointVector& v);

}  // namespace bayesctrl
