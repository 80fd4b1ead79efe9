#pragma once

#include <optional>
#include <vector>

#include "base/fields.hpp"
#include "physics/discrepancy/remainder.hpp"
#include "physics/effect.hpp"
#include "physics/plant.hpp"

namespace bayesctrl {

/// By how much a model may still be wrong where it was compared with recordings: standard deviations, one per joint or
/// one for all.
struct ModelUncertainty {
  std::vector<double> drift;       // of a_i, unit of q''
  std::vector<double> input_gain;  // of log b_ii
  std::vector<double> coupling;    // of b_ij off the diagonal; only for several joints

  static void fields(auto& self, auto&& field) {
    field("drift", self.drift,
          {.range = kPositive, .text = "standard deviation of a_i, in the unit of q''", .required = true});
    field("input_gain", self.input_gain,
          {.range = kPositive, .text = "standard deviation of log b_ii", .required = true});
    field("coupling", self.coupling, {.range = kPositive, .text = "standard deviation of b_ij off the diagonal"});
  }

  /// What is wrong with it for a machine of so many joints, in words; empty when nothing is.
  std::string problem(int joints) const;
  bool operator==(const ModelUncertainty&) const = default;
};

/// A simulated machine: nominal mechanics, physics beside it, and a torque that no physics explains. In specs:
/// `plant: NAME`, `parameters: {...}`, `effects: [...]`, `remainder: {...}`, `uncertainty: {...}`, or `file:
/// model.yaml`.
struct Model {
  static constexpr std::string_view kName = "model";
  Plant plant;
  std::vector<Effect> effects = {};
  Remainder remainder = {};
  std::optional<ModelUncertainty> uncertainty = {};  // of a and b, for those who believe in it

  bool is_plain() const { return effects.empty() && remainder.empty(); }
  bool operator==(const Model&) const = default;
};

/// q'' = a + b u as far as it is a function of the state: effects with a memory, in time or in the sensor are left out,
/// dry friction acts along the velocity. `celsius`: of each joint; none: 20 degrees.
Affine affine(const Model& model, const JointVector& q, const JointVector& v, const JointVector& celsius = {});

}  // namespace bayesctrl
