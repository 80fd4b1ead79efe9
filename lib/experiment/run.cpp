#include "experiment/run.hpp"

#include <algorithm>
#include <chrono>
#include <mutex>

#include "base/error.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

namespace {

using Clock = std::chrono::steady_clock;

StateVector to_state(const InitialState& initial) {
  StateVector x(static_cast<Eigen::Index>(initial.position.size() + initial.velocity.size()));
  std::copy(initial.position.begin(), initial.position.end(), x.begin());
  std::copy(initial.velocity.begin(), initial.velocity.end(),
            x.begin() + static_cast<std::ptrdiff_t>(initial.position.size()));
  return x;
}

LoopSetup to_setup(const Study& study, const Controller& controller) {
  LoopSetup setup;
  setup.plant = study.model.plant;
  setup.effects = study.model.effects;
  setup.remainder = study.model.remainder;
  setup.initial_state = to_state(study.initial_state);
  setup.reference = study.reference;
  setup.duration = study.duration;
  setup.control_period = study.control_period;
  setup.inner_law = study.inner_law;
  setup.input_limit = study.input_limit;
  setup.sensor = study.sensor;
  setup.integration = study.integration;
  setup.quadrature_step = study.output.quadrature_step;
  setup.time_calls = study.output.latency;
  setup.controller = controller;
  if (const auto* adaptive = std::get_if<Adaptive>(&controller)) {
    setup.learner = adaptive->learner ? *adaptive->learner : *study.learner;
    setup.tuning = adaptive->tuning.value_or(study.tuning);
    setup.belief = Belief(adaptive->belief ? *adaptive->belief : *study.belief, joints(study.model.plant));
  }
  return setup;
}

Outcome failure(const std::string& controller, std::string reason) {
  Outcome outcome{controller, {}, 0, 0};
  outcome.result.status = RunStatus::failed;
  outcome.result.reason = std::move(reason);
  return outcome;
}

Outcome run_controller(const StudyOutcome& so_far, const std::string& name, const Controller& controller) {
  const Study& study = so_far.study;
  try {
    LoopSetup setup = to_setup(study, controller);
    if (const auto* adaptive = std::get_if<Adaptive>(&controller); adaptive && !adaptive->trained_from.empty()) {
      const Outcome& teacher = *so_far.find(adaptive->trained_from);
      if (teacher.result.status != RunStatus::ok) {
        return failure(name, "'" + teacher.controller + "', whose data it starts with, failed");
      }
      setup.belief =
          adaptive->keep_hyper_parameters ? teacher.result.belief : setup.belief.with_samples(teacher.result.belief);
      setup.timings = teacher.result.learning.timings;
    }
    Outcome outcome{name, {}, setup.belief.drift_points(), setup.belief.gain_points()};
    outcome.result = run_loop(setup, random_stream(study.seed, name));
    return outcome;
  } catch (const NumericalError& error) {
    return failure(name, error.what());
  } catch (const std::bad_alloc&) {
    return failure(name, "out of memory");
  }
}

/// Controllers that must run one after another, by index into a study's list.
struct Chain {
  std::size_t study;
  std::vector<std::size_t> controllers;
};

std::vector<Chain> chains_of(const std::vector<Study>& studies) {
  std::vector<Chain> chains;
  for (std::size_t s = 0; s < studies.size(); ++s) {
    const auto& items = studies[s].controllers.items;
    std::vector<std::size_t> chain_of(items.size());
    for (std::size_t c = 0; c < items.size(); ++c) {
      const auto* adaptive = std::get_if<Adaptive>(&items[c].second);
      const auto teacher = std::find_if(items.begin(), items.end(), [&](const auto& item) {
        return adaptive != nullptr && item.first == adaptive->trained_from;
      });
      if (teacher != items.end()) {
        chain_of[c] = chain_of[static_cast<std::size_t>(teacher - items.begin())];
        chains[chain_of[c]].controllers.push_back(c);
      } else {
        chain_of[c] = chains.size();
        chains.push_back({s, {c}});
      }
    }
  }
  return chains;
}

}  // namespace

const Outcome* StudyOutcome::find(std::string_view controller) const {
  for (const Outcome& outcome : outcomes) {
    if (outcome.controller == controller) return &outcome;
  }
  return nullptr;
}

void run_all(const std::vector<Study>& studies, const RunOptions& options, const StudySink& sink) {
  const std::vector<Chain> chains = chains_of(studies);
  std::vector<StudyOutcome> results(studies.size());
  std::vector<std::size_t> open_chains(studies.size(), 0);
  std::size_t total = 0;
  for (const Chain& chain : chains) {
    ++open_chains[chain.study];
    total += chain.controllers.size();
  }

  std::mutex mutex;  // guards what is not of one chain alone, and the callbacks
  std::size_t done = 0;
  const auto begin_study = [&](std::size_t s) {
    const std::lock_guard lock(mutex);
    StudyOutcome& result = results[s];
    if (!result.outcomes.empty()) return;
    result.study = studies[s];
    for (const auto& [name, controller] : studies[s].controllers.items) result.outcomes.push_back({name, {}, 0, 0});
  };
  const auto end_controller = [&](std::size_t s, double seconds) {
    const std::lock_guard lock(mutex);
    results[s].wall_seconds += seconds;
    if (options.progress) options.progress(++done, total);
  };
  const auto is_last = [&](std::size_t s) {
    const std::lock_guard lock(mutex);
    return --open_chains[s] == 0;
  };
  in_parallel(chains.size(), options.jobs, [&](std::size_t i) {
    const Chain& chain = chains[i];
    begin_study(chain.study);
    StudyOutcome& result = results[chain.study];
    for (const std::size_t c : chain.controllers) {
      const auto& [name, controller] = studies[chain.study].controllers.items[c];
      const auto begin = Clock::now();
      Outcome outcome = options.stop && options.stop() ? failure(name, std::string(kInterrupted))
                                                       : run_controller(result, name, controller);
      Outcome& slot = result.outcomes[c];  // whose name stays: other chains look for theirs meanwhile
      slot.result = std::move(outcome.result);
      slot.start_drift_points = outcome.start_drift_points;
      slot.start_gain_points = outcome.start_gain_points;
      end_controller(chain.study, std::chrono::duration<double>(Clock::now() - begin).count());
    }
    if (!is_last(chain.study)) return;
    sink(chain.study, std::move(result));
    result = {};
  });
}

std::vector<StudyOutcome> run_all(const std::vector<Study>& studies, const RunOptions& options) {
  std::vector<StudyOutcome> results(studies.size());
  run_all(studies, options, [&](std::size_t index, StudyOutcome&& outcome) { results[index] = std::move(outcome); });
  return results;
}

}  // namespace bayesctrl
