#include "experiment/study.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "sim/loop.hpp"

namespace bayesctrl {

namespace {

constexpr double kMostSteps = 1e7;  // control calls of one run: beyond this the memory for its trajectory is not there

Problem joints_problem(const std::string& path, std::size_t given, int joints) {
  if (static_cast<int>(given) == joints) return {};
  return {path + " has " + std::to_string(given) + (given == 1 ? " value" : " values") + ", but the plant has " +
              std::to_string(joints) + (joints == 1 ? " joint" : " joints"),
          path};
}

Problem one_or_each(const std::string& path, std::size_t given, int joints) {
  return given <= 1 ? Problem{} : joints_problem(path, given, joints);
}

/// `path`: of the learner.
Problem learner_problem(const Study& study, const Learner& learner, const std::string& path, int joints) {
  const double ratio = learner.period / study.control_period;
  if (ratio < 0.5 || std::abs(ratio - std::round(ratio)) > 1e-6 * ratio) {
    return {"learner.period = " + format(learner.period) +
                " s is not a multiple of control_period = " + format(study.control_period) + " s",
            path + ".period"};
  }
  Problem problem = one_or_each("learner.probing_input", learner.probing_input.size(), joints);
  if (learner.probing_input.empty()) problem.text = "learner.probing_input is empty";
  problem.path = path + ".probing_input";
  return problem;
}

Problem adaptive_problem(const Study& study, const std::string& name, const Adaptive& controller, int joints) {
  const std::string who = "controller '" + name + "' ", own = "controllers." + name;
  const auto& belief = controller.belief ? controller.belief : study.belief;
  const auto& learner = controller.learner ? controller.learner : study.learner;
  const Tuning& tuning = controller.tuning ? *controller.tuning : study.tuning;
  if (!belief) return {who + "is adaptive and needs a belief, its own or the study's", own};
  if (!learner) return {who + "is adaptive and needs a learner, its own or the study's", own};
  if (tuning.when != TuneWhen::never && learner->gain_noise == GainNoise::propagated) {
    return {who + "tunes one noise variance for all samples, which gain_noise: propagated contradicts", own};
  }
  if (std::string text = belief->problem(joints); !text.empty()) {
    return {who + "has a belief in which " + text, controller.belief ? own + ".belief" : "belief"};
  }
  const std::string at = controller.learner ? own + ".learner" : "learner";
  if (Problem problem = learner_problem(study, *learner, at, joints); !problem.empty()) return problem;
  if (controller.trained_from.empty()) return {};
  if (controller.belief && controller.keep_hyper_parameters) {
    return {who + "has a belief of its own, of which nothing is used unless keep_hyper_parameters: false",
            own + ".belief"};
  }

  std::vector<std::string_view> earlier;
  for (const auto& [key, other] : study.controllers.items) {
    if (key == name) break;
    if (std::holds_alternative<Adaptive>(other)) earlier.push_back(key);
  }
  if (std::find(earlier.begin(), earlier.end(), controller.trained_from) == earlier.end()) {
    return {who + "is trained_from '" + controller.trained_from + "', which is no adaptive controller above it" +
                (earlier.empty() ? "" : ", " + suggestion(controller.trained_from, earlier)),
            own + ".trained_from"};
  }
  return {};
}

}  // namespace

Problem Study::problem() const {
  const int n = joints(model.plant);
  const double steps = duration / control_period;
  if (!(steps >= 1.0 - 1e-9)) return {"duration is shorter than one control_period", "duration"};
  if (!(steps <= kMostSteps)) {
    return {"duration / control_period = " + format(steps, 3) + " control calls, at most " + format(kMostSteps),
            "duration"};
  }
  if (output.quadrature_step && !(duration / *output.quadrature_step <= kMostSteps)) {
    return {"duration / quadrature_step = " + format(duration / *output.quadrature_step, 3) + " steps, at most " +
                format(kMostSteps),
            "output.quadrature_step"};
  }
  Problem problem = joints_problem("initial_state.position", initial_state.position.size(), n);
  if (problem.empty()) problem = joints_problem("initial_state.velocity", initial_state.velocity.size(), n);
  if (problem.empty()) problem = joints_problem("reference", static_cast<std::size_t>(joints(reference)), n);
  if (problem.empty()) problem = one_or_each("input_limit", input_limit.size(), n);
  if (problem.empty() && controllers.items.empty()) problem = {"controllers is empty", "controllers"};
  for (const auto& [key, controller] : controllers.items) {
    if (!problem.empty()) break;
    if (const auto* adaptive = std::get_if<Adaptive>(&controller)) problem = adaptive_problem(*this, key, *adaptive, n);
  }
  return problem;
}

}  // namespace bayesctrl
