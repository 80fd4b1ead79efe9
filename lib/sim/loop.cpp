#include "sim/loop.hpp"

#include <chrono>
#include <cmath>

#include "base/error.hpp"
#include "numerics/detail/dormand_prince.hpp"
#include "physics/machine/simulation.hpp"

namespace bayesctrl {

namespace {

constexpr double kLongestStep = 2e-3;  // s, of a machine with effects

/// The learner as the machine lets it act: what is learned from a probe is the effect of the input that was applied.
Learner within_limits(Learner learner, const std::vector<double>& limit, int inputs) {
  if (limit.empty() || learner.probing_input.empty()) return learner;
  JointVector u(inputs);
  for (int j = 0; j < inputs; ++j) u[j] = probing_input(learner, {j, 0}, inputs)[j];
  u = limited(u, limit);
  learner.probing_input.assign(u.begin(), u.end());
  return learner;
}

/// One run of one controller on one plant; the types are fixed so that the inner loop has no dispatch.
template <class PlantType, std::size_t kJoints, class ControllerType>
class Loop {
  using OdeState = std::array<double, 2 * kJoints + 2>;  // q, v, integral of |u|^2, integral of |x - xi|^2

 public:
  Loop(const LoopSetup& setup, const PlantType& plant, const ControllerType& controller, RandomStream random)
      : setup_(setup),
        plant_(plant),
        controller_(controller),
        dt_(setup.control_period),
        count_(control_steps(setup.duration, setup.control_period)),
        measurement_(setup.sensor, dt_, kJoints, static_cast<std::size_t>(count_) + 1, random) {
    for (std::size_t i = 0; i < 2 * kJoints; ++i) y_[i] = setup.initial_state[static_cast<Eigen::Index>(i)];
    if (!setup.effects.empty() || !setup.remainder.empty()) {
      truth_ = Model{setup.plant, setup.effects, setup.remainder};
      machine_.emplace(setup.plant, setup.effects, setup.remainder);
      simulation_.emplace(*machine_, setup.initial_state, 0.0, kLongestStep);
    }
    result_.steps.reserve(static_cast<std::size_t>(count_) + 1);
    if (setup.time_calls) result_.call_seconds.reserve(static_cast<std::size_t>(count_) + 1);
    if constexpr (kLearns) {
      result_.beliefs.reserve(kJoints, count_ + 1);
      learning_.emplace(LearningSetup{within_limits(setup.learner, setup.input_limit, kJoints), setup.tuning, dt_,
                                      count_, setup.sensor.positions_only, setup.timings},
                        setup.belief, random);
    }
  }

  LoopResult run() {
    try {
      for (long k = 0; k < count_; ++k) advance(k);
      record(static_cast<double>(count_) * dt_, count_);
      if constexpr (kLearns) learning_->finish();
    } catch (const NumericalError& error) {
      result_.status = RunStatus::failed;
      result_.reason = error.what();
      // A control call that failed has settled no input: its step is left out.
      if (!result_.steps.empty() && result_.steps.back().input.size() == 0) result_.steps.pop_back();
    }
    if constexpr (kLearns) {
      result_.learning = learning_->record();
      result_.belief = learning_->take_belief();
    }
    result_.energy = y_[2 * kJoints];
    result_.squared_error = y_[2 * kJoints + 1];
    return std::move(result_);
  }

 private:
  static constexpr bool kLearns = ControllerType::kKnowledge == Knowledge::belief;

  using PlantVector = Joints<static_cast<int>(kJoints)>;

  static PlantVector part(const OdeState& y, std::size_t first) {
    return Eigen::Map<const PlantVector>(y.data() + first);
  }

  /// The reference, which is asked for at every stage of the integration: one that stays where it is is kept.
  const ReferencePoint& reference(double t) {
    if (!constant_reference_) reference_ = at(setup_.reference, t);
    return reference_;
  }

  StateVector state() const { return Eigen::Map<const StateVector>(y_.data(), 2 * kJoints); }

  void advance(long k) {
    record(static_cast<double>(k) * dt_, k);
    const LoopStep& step = result_.steps.back();
    if constexpr (ControllerType::kContinuous) {
      hold_nothing(step.time);
    } else {
      const PlantVector u = step.input;
      integrate_period(step.time, step.time + dt_, [&u](const OdeState&, double) -> const PlantVector& { return u; });
      if (setup_.quadrature_step) result_.energy_riemann += u.squaredNorm() * dt_;
    }
  }

  /// Continuous control over one period, in steps of the quadrature if one is asked for.
  void hold_nothing(double from) {
    const auto law = [this](const OdeState& y, double t) { return control(part(y, 0), part(y, kJoints), t, nullptr); };
    const long pieces = setup_.quadrature_step ? std::max(1L, std::lround(dt_ / *setup_.quadrature_step)) : 1;
    const double piece = dt_ / static_cast<double>(pieces);
    for (long i = 0; i < pieces; ++i) {
      const double end = from + static_cast<double>(i + 1) * piece;
      integrate_period(end - piece, end, law);
      if (setup_.quadrature_step) result_.energy_riemann += law(y_, end).squaredNorm() * piece;
    }
  }

  /// The same for a machine with more physics than its plant's: its input is held over pieces of the period, the error
  /// is summed by the trapezoidal rule.
  void simulate_period(double t0, double t1, auto&& law) {
    const auto pieces = static_cast<int>(std::ceil((t1 - t0) / kLongestStep));
    const double h = (t1 - t0) / pieces;
    const auto error = [&](double t) {
      const ReferencePoint& xi = reference(t);
      return (part(y_, 0) - xi.position).squaredNorm() + (part(y_, kJoints) - xi.velocity).squaredNorm();
    };
    for (int i = 0; i < pieces; ++i) {
      const double t = t0 + i * h;
      const JointVector u = law(y_, t);
      if (i == 0 || ControllerType::kContinuous) simulation_->hold(u);
      const double before = error(t);
      simulation_->advance(t + h);
      const StateVector now = simulation_->state();
      for (std::size_t k = 0; k < 2 * kJoints; ++k) y_[k] = now[static_cast<Eigen::Index>(k)];
      y_[2 * kJoints] += u.squaredNorm() * h;
      y_[2 * kJoints + 1] += 0.5 * h * (before + error(t + h));
    }
  }

  void integrate_period(double t0, double t1, auto&& law) {
    if (simulation_) return simulate_period(t0, t1, law);
    const auto equation = [&](const OdeState& y, OdeState& dydt, double t) {
      const PlantVector q = part(y, 0), v = part(y, kJoints);
      const auto& u = law(y, t);
      const ReferencePoint& xi = reference(t);
      if constexpr (requires { plant_.acceleration(q, v, u, t); }) {
        const JointVector a = plant_.acceleration(q, v, u, t);
        for (std::size_t i = 0; i < kJoints; ++i) dydt[kJoints + i] = a[static_cast<Eigen::Index>(i)];
      } else {
        const Affine affine = plant_.affine(q, v);
        for (std::size_t i = 0; i < kJoints; ++i) {
          const auto row = static_cast<Eigen::Index>(i);
          dydt[kJoints + i] = affine.drift[row] + affine.gain.row(row).dot(u);
        }
      }
      for (std::size_t i = 0; i < kJoints; ++i) dydt[i] = v[static_cast<Eigen::Index>(i)];
      dydt[2 * kJoints] = u.squaredNorm();
      dydt[2 * kJoints + 1] = (q - xi.position).squaredNorm() + (v - xi.velocity).squaredNorm();
    };
    integrate(equation, y_, t0, t1, setup_.integration, step_);
  }

  /// The control law at one state, with the input limits.
  JointVector control(const JointVector& q, const JointVector& v, double t, const BeliefMarginals* belief) {
    const JointVector acceleration = setup_.inner_law(reference(t), q, v);
    const double lead = setup_.inner_law.lead;
    LawInput input{acceleration, nullptr, belief};
    Affine truth;
    if constexpr (ControllerType::kKnowledge == Knowledge::truth) {
      const JointVector at = v + lead * acceleration;
      truth = truth_ ? affine(*truth_, q, at) : plant_.affine(q, at);
      input.truth = &truth;
    }
    BeliefMarginals ahead;
    if constexpr (kLearns) {
      if (lead > 0.0) {
        StateVector x(2 * kJoints);
        x << q, v + lead * acceleration;
        ahead = learning_->belief().predict(x);
        input.belief = &ahead;
      }
    }
    return limited(controller_(input), setup_.input_limit);
  }

  /// Samples the state and settles the input of control call k.
  void record(double time, long k) {
    LoopStep& step = result_.steps.emplace_back();
    step.time = time;
    step.position = part(y_, 0);
    step.velocity = part(y_, kJoints);
    step.reference = reference(time);
    const StateVector seen = ControllerType::kContinuous ? state() : measurement_(state());
    if (!setup_.time_calls) return decide(step, seen, k);
    const auto begin = std::chrono::steady_clock::now();
    decide(step, seen, k);
    result_.call_seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }

  /// What the controller does at call k, having seen this state.
  void decide(LoopStep& step, const StateVector& seen, long k) {
    const double time = step.time;
    if constexpr (kLearns) {
      const InnerLaw& law = setup_.inner_law;
      const JointVector error = step.reference.velocity - seen.tail(kJoints) +
                                std::sqrt(law.position_weight) * (step.reference.position - seen.head(kJoints));
      const BeliefMarginals believed = learning_->see(k, seen, error);
      if (const auto& probe = learning_->probe()) {
        step.mode = probe->column;
        step.input = learning_->input();
      } else {
        step.input = control(seen.head(kJoints), seen.tail(kJoints), time, &believed);
      }
      result_.beliefs.push_back(believed);
      learning_->hold(step.input);
    } else {
      step.input = control(seen.head(kJoints), seen.tail(kJoints), time, nullptr);
    }
  }

  const LoopSetup& setup_;
  const PlantType& plant_;
  const ControllerType& controller_;
  double dt_;
  long count_;
  Measurement measurement_;
  bool constant_reference_ = std::holds_alternative<Setpoint>(setup_.reference);
  ReferencePoint reference_ = at(setup_.reference, 0.0);
  std::optional<Model> truth_;  // of a machine with effects, as are the two below
  std::optional<Machine> machine_;
  std::optional<Simulation> simulation_;
  OdeState y_{};
  double step_ = dt_;
  std::optional<Learning> learning_;  // of a controller that learns
  LoopResult result_;
};

}  // namespace

long control_steps(double duration, double control_period) {
  return static_cast<long>(std::floor(duration / control_period * (1.0 + 1e-12)));
}

LoopResult run_loop(const LoopSetup& setup, RandomStream random) {
  return with_joints(setup.plant, [&]<class P, int kJoints>(const P& plant, std::integral_constant<int, kJoints>) {
    return std::visit(
        [&]<class C>(const C& controller) {
          return Loop<P, static_cast<std::size_t>(kJoints), C>(setup, plant, controller, random).run();
        },
        setup.controller);
  });
}

}  // namespace bayesctrl
