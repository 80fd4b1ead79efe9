#pragma once

#include "control/law.hpp"
#include "control/law_input.hpp"

namespace bayesctrl {

/// Feedback linearisation with the true a and b: the limit that any learner can reach.
struct Oracle {
  static constexpr std::string_view kName = "oracle";
  static constexpr std::string_view kText = "the limit of any learner: feedback linearisation with the true a and b";
  static constexpr std::string_view kEquation = "u = b(x)^-1 (u' - a(x)), u' of the inner law";
  static constexpr bool kContinuous = false;
  static constexpr Knowledge kKnowledge = Knowledge::truth;

  static void fields(auto& /*self*/, auto&& /*field*/) {}

  JointVector operator()(const LawInput& in) const {
    return feedback_linearise(in.truth->drift, in.truth->gain, in.acceleration);
  }
  bool operator==(const Oracle&) const = default;
};

}  // namespace bayesctrl
