#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "experiment/study.hpp"
#include "sim/loop.hpp"

namespace bayesctrl {

/// What became of one controller of a study.
struct Outcome {
  std::string controller;
  LoopResult result;
  int start_drift_points = 0;  // data that it started with, from `trained_from`
  int start_gain_points = 0;
};

/// The controllers of a study in the order of the spec. Each controller's random stream follows from the study's seed
/// and the controller's name alone.
struct StudyOutcome {
  Study study;
  std::vector<Outcome> outcomes;
  double wall_seconds = 0.0;  // summed over the controllers

  const Outcome* find(std::string_view controller) const;
};

/// The reason of a run that was stopped before it began.
inline constexpr std::string_view kInterrupted = "interrupted";

/// How a batch is run and who hears of it. `progress` may come from any thread, but one at a time.
struct RunOptions {
  int jobs = 0;                                                       // threads; 0: all cores
  std::function<void(std::size_t done, std::size_t total)> progress;  // after each controller
  std::function<bool()> stop;  // asked before each controller: what has not started by then fails, kInterrupted
};

/// Takes the results of one study, by its index, as soon as all its controllers are through. May come from several
/// threads at once.
using StudySink = std::function<void(std::size_t index, StudyOutcome&& outcome)>;

/// Runs every controller of every study. Controllers that build on one another's data run in sequence, the rest in any
/// order; results do not depend on `jobs`. An exception of the sink ends the batch and is passed on.
void run_all(const std::vector<Study>& studies, const RunOptions& options, const StudySink& sink);

/// The same, all kept in memory, in order.
std::vector<StudyOutcome> run_all(const std::vector<Study>& studies, const RunOptions& options = {});

}  // namespace bayesctrl
