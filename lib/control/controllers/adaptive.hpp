#pragma once

#include <optional>
#include <string>

#include "control/law.hpp"
#include "control/law_input.hpp"
#include "control/learner.hpp"
#include "control/tuning.hpp"

namespace bayesctrl {

/// The paper's SP: feedback linearisation with the posterior means of a and b, learned online by probing.
struct Adaptive {
  static constexpr std::string_view kName = "adaptive";
  static constexpr std::string_view kText =
      "the paper's SP: feedback linearisation with posterior means, learned online";
  static constexpr std::string_view kEquation =
      "u = (E b(x))^-1 (u' - E a(x)), u' of the inner law; with a monitor the u that minimises |E q'' - u'|^2 + "
      "caution * var q''";
  static constexpr bool kContinuous = false;
  static constexpr Knowledge kKnowledge = Knowledge::belief;
  std::string trained_from;
  double caution = 0.1;
  bool keep_hyper_parameters = true;
  std::optional<BeliefPrior> belief;
  std::optional<Learner> learner;
  std::optional<Tuning> tuning;

  static void fields(auto& self, auto&& field) {
    field("trained_from", self.trained_from, {.text = "controller whose run's data this one starts with; empty: none"});
    field("caution", self.caution,
          {kNonNegative, "",
           "where a and b are learned together (learner.monitor): weight of the variance of q'' beside the square of "
           "what its mean misses of u'; 0: by the means alone, as where they are apart"});
    field("keep_hyper_parameters", self.keep_hyper_parameters,
          {.text = "with trained_from: start from the tuned hyper-parameters too, else from the prior's"});
    field("belief", self.belief, {.text = "priors of this controller instead of the study's"});
    field("learner", self.learner, {.text = "learner of this controller instead of the study's"});
    field("tuning", self.tuning, {.text = "tuning of this controller instead of the study's"});
  }

  JointVector operator()(const LawInput& in) const {
    return linearise_cautiously(*in.belief, in.acceleration, caution);
  }
};

}  // namespace bayesctrl
