#pragma once

#include <array>
#include <string_view>

#include "diagnose/motion/smoother.hpp"
#include "physics/discrepancy/remainder.hpp"
#include "physics/effect.hpp"

namespace bayesctrl {

/// On what a torque may depend.
enum class Cause { position, velocity, input, time, history };
constexpr std::array<std::string_view, 5> names(Cause) { return {"position", "velocity", "input", "time", "history"}; }

/// What terms are for.
enum class TermUse {
  compare,     // causes with one another
  rich,        // the product of two causes, the past of one, or finer than what causes are compared by
  parametric,  // few numbers, which extrapolate: to predict where nothing was seen, not to say what may be missing
};

/// Terms that say together how a torque may depend on one cause.
struct TermGroup {
  Cause cause = Cause::position;
  TermUse use = TermUse::compare;
  int joint = 0;
  std::vector<Term> terms;
};

/// All groups for one joint, spread over what the motion along `paths` visits; `seen` is its operating range.
std::vector<TermGroup> term_groups(const OperatingRange& seen, const std::vector<Trajectory>& paths, int joint);

}  // namespace bayesctrl
