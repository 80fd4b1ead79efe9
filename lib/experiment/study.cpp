#include "experiment/study.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "sim/loop.hpp"

namespace bayesctrl {

namespace {

constexpr double kMostSteps = 1e7;  // control calls of one run: beyond this the memory for its trajectory is not there

std::string joints_problem(std::string_view what, std::size_t given, int joints) {
  if (static_cast<int>(given) == joints) return "";
  return std::string(what) + " has " + std::to_string(given) + (given == 1 ? " value" : " values") +
         ", but the plant has " + std::to_string(joints) + (joints == 1 ? " joint" : " joints");
}

std::string one_or_each(std::string_view what, std::size_t given, int joints) {
  return given <= 1 ? "" : joints_problem(what, given, joints);
}

std::string learner_problem(const Study& study, const Learner& learner, int joints) {
  const double ratio = learner.period / study.control_period;
  if (ratio < 0.5 || std::abs(ratio - std::round(ratio)) > 1e-6 * ratio) {
    return "learner.period = " + format(learner.period) +
           " s is not a multiple of control_period = " + format(study.control_period) + " s";
  }
  if (learner.probing_input.empty()) return "learner.probing_input is empty";
  return one_or_each("learner.probing_input", learner.probing_input.size(), joints);
}

std::string adaptive_problem(const Study& study, const std::string& name, const Adaptive& controller, int joints) {
  const std::string who = "controller '" + name + "' ";
  const auto& belief = controller.belief ? controller.belief : study.belief;
  const auto& learner = controller.learner ? controller.learner : study.learner;
  const Tuning& tuning = controller.tuning ? *controller.tuning : study.tuning;
  if (!belief) return who + "is adaptive and needs a belief, its own or the study's";
  if (!learner) return who + "is adaptive and needs a learner, its own or the study's";
  if (tuning.when != TuneWhen::never && learner->gain_noise == GainNoise::propagated) {
    return who + "tunes one noise variance for all samples, which gain_noise: propagated contradicts";
  }
  if (std::string text = belief->problem(joints); !text.empty()) return who + "has a belief in which " + text;
  if (std::string text = learner_problem(study, *learner, joints); !text.empty()) return text;
  if (controller.trained_from.empty()) return "";
  if (controller.belief && controller.keep_hyper_parameters) {
    return who + "has a belief of its own, of which nothing is used unless keep_hyper_parameters: false";
  }

  std::vector<std::string_view> earlier;
  for (const auto& [key, other] : study.controllers.items) {
    if (key == name) break;
    if (std::holds_alternative<Adaptive>(other)) earlier.push_back(key);
  }
  if (std::find(earlier.begin(), earlier.end(), controller.trained_from) == earlier.end()) {
    return who + "is trained_from '" + controller.trained_from + "', which is no adaptive controller above it" +
           (earlier.empty() ? "" : ", " + suggestion(controller.trained_from, earlier));
  }
  return "";
}

}  // namespace

std::string Study::problem() const {
  const int n = joints(model.plant);
  const double steps = duration / control_period;
  if (!(steps >= 1.0 - 1e-9)) return "duration is shorter than one control_period";
  if (!(steps <= kMostSteps)) {
    return "duration / control_period = " + format(steps, 3) + " control calls, at most " + format(kMostSteps);
  }
  std::string text = joints_problem("initial_state.position", initial_state.position.size(), n);
  if (text.empty()) text = joints_problem("initial_state.velocity", initial_state.velocity.size(), n);
  if (text.empty()) text = joints_problem("reference", static_cast<std::size_t>(joints(reference)), n);
  if (text.empty()) text = one_or_each("input_limit", input_limit.size(), n);
  if (text.empty() && controllers.items.empty()) text = "controllers is empty";
  for (const auto& [key, controller] : controllers.items) {
    if (!text.empty()) break;
    if (const auto* adaptive = std::get_if<Adaptive>(&controller)) text = adaptive_problem(*this, key, *adaptive, n);
  }
  return text;
}

}  // namespace bayesctrl
