#pragma once

#include <optional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "control/belief_record.hpp"
#include "control/controller.hpp"
#include "control/law.hpp"
#include "control/learning.hpp"
#include "control/reference.hpp"
#include "control/tuning.hpp"
#include "numerics/integrate.hpp"
#include "physics/model.hpp"
#include "sim/sensor.hpp"

namespace bayesctrl {

/// Everything that one closed-loop run needs, resolved.
struct LoopSetup {
  Plant plant;
  std::vector<Effect> effects;  // physics beside the plant's, part of the truth
  Remainder remainder;
  StateVector initial_state;  // [q, v]
  Reference reference;
  double duration = 1.0;         // s
  double control_period = 0.01;  // s
  InnerLaw inner_law;
  std::vector<double> input_limit;  // empty: none
  Sensor sensor;
  Integration integration;
  std::optional<double> quadrature_step;  // s; report the right-end Riemann sum of u^2 of this step as well
  bool time_calls = false;                // of the controller
  Controller controller;
  Belief belief;  // what an adaptive controller starts with
  Learner learner;
  Tuning tuning;
  std::optional<Timings> timings{};  // how late inputs act, if an earlier run has found it
};

/// What the loop was doing at one control call.
struct Mode {
  static constexpr int kControl = -2;
  static constexpr int kLearnDrift = Probe::kDrift;  // and j >= 0: learn column j of the gain
};

/// One control call: the true state and the input held from here on. For a continuous controller, the input at this
/// instant.
struct LoopStep {
  double time = 0.0;
  JointVector position, velocity, input;
  ReferencePoint reference;
  int mode = Mode::kControl;
};

enum class RunStatus { ok, failed };
constexpr std::array<std::string_view, 2> names(RunStatus) { return {"ok", "failed"}; }

struct LoopResult {
  RunStatus status = RunStatus::ok;
  std::string reason;                // of a failure; the steps up to it are kept
  std::vector<LoopStep> steps;       // one per control call, and the final state
  BeliefRecord beliefs;              // of an adaptive controller, at the measured state of each step
  double energy = 0.0;               // integral of |u|^2
  double squared_error = 0.0;        // integral of |x - xi|^2
  double energy_riemann = 0.0;       // right-end Riemann sum of |u|^2, if asked for
  std::vector<double> call_seconds;  // wall time of each control call, if asked for
  Belief belief;                     // as it is at the end
  LearningRecord learning;
};

/// Runs the loop: sample, learn, decide, hold, integrate. Energy and error are states of the integration. A numerical
/// failure ends the run with `failed`. `random` drives sensor noise and restarts of the tuning.
LoopResult run_loop(const LoopSetup& setup, RandomStream random);

/// Control periods in `duration`; a last incomplete period is dropped.
long control_steps(double duration, double control_period);

}  // namespace bayesctrl
