#pragma once

#include "diagnose/explain.hpp"

namespace bayesctrl {

std::vector<std::string> labels(const std::vector<Effect>& effects, int joints);

/// Classes of effects that replace each other in the best explanation with hardly any loss.
struct Alike {
  std::vector<std::vector<std::string>> classes;  // one per effect of the best set, the effect itself first
  double probability = 0.0;                       // of all sets made of them
};
Alike find_alike(const Explanation& explanation, int joints);

/// The effect without which the explanation loses most.
std::size_t strongest(const Explanation& explanation);

/// RMS error of a model's free runs over the training windows beyond the sensor's noise.
double error_beyond_noise(const Fit& fit, const Explanation& explanation, const std::vector<Measured>& data,
                          const std::vector<Trajectory>& paths, double horizon);

/// Where the best explanation leaves more than noise, likelihoods between imperfect models mean little. Then the one
/// comes first whose free runs are best for its size: every number has to take away a fifth of the error. Its
/// parameters are those that are most probable beside a random force, unless free runs contradict them; their
/// deviations are those beside a random force in any case.
/// Probabilities are those beside the same force, among
/// explanations with no more numbers.
void prefer_simple(Explanation& explanation, const std::vector<Measured>& data, const ExplainOptions& options,
                   double horizon);

}  // namespace bayesctrl
