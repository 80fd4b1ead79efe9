#pragma once

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

std::vector<std::string> labels(const std::vector<Effect>& effects, int joints);

/// Observationally equivalent effects: classes that replace each other in the best explanation with hardly any loss.
struct Equivalence {
  std::vector<std::vector<std::string>> classes;  // one per effect of the best set, the effect itself first
  std::vector<double> inclusion;                  // of any of a class, over all sets
  double probability = 0.0;                       // of all sets made of them,
  std::vector<const Candidate*> sets;             // which are these

  /// Whether each is part of the machine, and the whole more probable than not.
  bool sure() const;
};
Equivalence find_equivalent(const Explanation& explanation, int joints);

/// Vuong-bounded evidence: nats by which one model is better than another where neither is right. `nats`, but no more
/// than the odds that its advantage is more than the scatter of its parts (Vuong 1989, with Student's distribution).
/// `more`: half the square that the other model leaves in each row less that of this one.
double vuong_bounded(double nats, const Eigen::VectorXd& more);

/// The effect without which the explanation loses most.
std::size_t strongest(const Explanation& explanation);

/// What an RMS error has beside that of the noise.
double beyond_noise(double error, double noise);

/// RMS error of a model's free runs over the training windows beyond the sensor's noise.
double error_beyond_noise(const Fit& fit, const Explanation& explanation, const std::vector<Measured>& data,
                          const std::vector<Trajectory>& paths, double horizon);

/// Where the best explanation leaves more than noise, likelihoods between imperfect models mean little. Then free runs
/// say how many numbers are worth their while: every one has to take away a fifth of the error. Among explanations with
/// no more numbers the one comes first that is most probable with process noise, with the parameters that are most
/// probable there unless free runs contradict them, and with their deviations.
void prefer_simple(Explanation& explanation, const std::vector<Measured>& data, const ExplainOptions& options,
                   double horizon);

}  // namespace bayesctrl
