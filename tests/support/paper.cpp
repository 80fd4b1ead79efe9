#include "support/paper.hpp"

#include <numbers>

#include "support/dense_gp.hpp"
#include "support/families.hpp"

namespace bayesctrl::testing {

LoopSetup paper_experiment(int number, Controller controller) {
  LoopSetup setup;
  setup.plant = number == 1 ? Pendulum{.length = 1.0, .friction = 1.0, .mass = 0.5}
                            : Pendulum{.length = 1.0, .friction = 0.5, .mass = 4.0};
  setup.initial_state = Eigen::Vector2d(0.0, -2.0);
  setup.reference = Setpoint{{std::numbers::pi}};
  setup.duration = number == 2 ? 15.0 : 20.0;
  setup.control_period = 0.01;
  setup.inner_law = number == 1 ? InnerLaw{1.0, 1.0} : InnerLaw{2.0, 2.0};
  setup.learner.period = number == 1 ? 0.5 : 1.0;
  setup.learner.drift_threshold = 0.001;
  setup.learner.gain_threshold = 0.005;
  setup.controller = std::move(controller);
  return setup;
}

LoopSetup example_setup(const Plant& plant, const Controller& controller, double duration) {
  const int n = joints(plant);
  LoopSetup setup;
  setup.plant = plant;
  setup.initial_state = StateVector::LinSpaced(2 * n, 0.4, -0.7);
  setup.reference = Setpoint{std::vector<double>(static_cast<std::size_t>(n), 0.5)};
  setup.duration = duration;
  setup.inner_law = {4.0, 4.0};
  setup.controller = controller;
  setup.belief = example_belief(n, 10);
  return setup;
}

BeliefPrior example_prior(int joints) {
  SquaredExponential form{1.0, std::vector<double>(static_cast<std::size_t>(2 * joints), 2.0)};
  const GaussianProcess process = process_with(Kernel{form}, 1e-2);
  BeliefPrior prior;
  prior.drift = prior.coupling = {process};
  prior.input_gain = {LogNormalProcess{process}};
  return prior;
}

Belief example_belief(int joints, int samples) {
  Belief belief(example_prior(joints), joints);
  const Eigen::MatrixXd points = random_points(samples, 2 * joints, 2.0, 3);
  for (int s = 0; s < samples; ++s) {
    const Eigen::VectorXd x = points.row(s);
    const double value = 0.3 * smooth(x);
    for (int i = 0; i < joints; ++i) {
      belief.drift(i).extend(span_of(x), value);
      for (int j = 0; j < joints; ++j) belief.gain(i, j).extend(span_of(x), i == j ? 0.1 * value : 0.05 * value);
    }
  }
  return belief;
}

Learner never_learning() {
  Learner learner;
  learner.drift_threshold = 1e6;
  learner.gain_threshold = 1e6;
  return learner;
}

bool same_steps(const LoopResult& one, const LoopResult& other) {
  if (one.steps.size() != other.steps.size()) return false;
  for (std::size_t k = 0; k < one.steps.size(); ++k) {
    const LoopStep& a = one.steps[k];
    const LoopStep& b = other.steps[k];
    const bool same = a.time == b.time && a.position == b.position && a.velocity == b.velocity && a.input == b.input &&
                      a.mode == b.mode;
    if (!same) return false;
  }
  return true;
}

}  // namespace bayesctrl::testing
