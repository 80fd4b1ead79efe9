#pragma once

#include <optional>
#include <vector>

#include "base/random.hpp"
#include "control/learner.hpp"
#include "control/tuning.hpp"
#include "control/window_sampler.hpp"

namespace bayesctrl {

/// What a run learns by.
struct LearningSetup {
  Learner learner;  // whose probing input is within the limits of the machine
  Tuning tuning;
  double control_period = 0.01;  // s
  long calls = 0;                // of the controller; no probe begins at the last
  bool positions_only = false;
  std::optional<Timings> timings{};  // known from an earlier run
};

/// What happened while a run learned.
struct LearningRecord {
  int refused_gain_estimates = 0;  // estimates of b that were not positive
  int tuning_evaluations = 0;      // of the marginal likelihood
  int failed_tunings = 0;          // after which the hyper-parameters stayed as they were
  int skipped_samples = 0;         // that a process could not take
  int passing_samples = 0;         // taken without a probe
  bool monitored = false;          // there is a monitor
  std::vector<double> alarms;      // times at which it raised one (s)
  std::optional<Timings> timings;  // how late inputs were found to act, once that was known
};

/// The learning procedure over one run: watches the machine, decides what to probe, takes samples, tunes
/// hyper-parameters, and widens a prior whose surprises are too large.
class Learning {
 public:
  Learning(LearningSetup setup, Belief belief, RandomStream random);

  /// Control call k sees `seen`: learns from what is complete, and returns what is believed there. `error` is the
  /// tracking error r of each joint, of a learner with an error_share.
  BeliefMarginals see(long k, const StateVector& seen, const JointVector& error = {});

  /// The running probe, if any, and its input at the last call.
  const std::optional<Probe>& probe() const { return probe_; }
  JointVector input() const;

  /// The input that is held until the next call.
  void hold(const JointVector& input) { history_.hold(input); }

  /// The run is over.
  void finish();

  const Belief& belief() const { return belief_; }
  Belief take_belief() { return std::move(belief_); }
  const LearningRecord& record() const { return record_; }

 private:
  StateVector state(long k) const;
  void finish_probe(long k);
  void end_probe(long k);
  bool asks_timing() const;
  void time_probe(long k);
  double inaccuracy(const Derivative& sample) const;
  bool vague(const BeliefMarginals& believed) const;
  void pass(long k);
  void start_probe(const JointVector& error, long k);
  Derivative three_samples(long first) const;
  WindowSample window(long first, int samples) const;
  void add_jump(Derivative& sample, long k) const;
  int passing_samples(long k) const;
  bool alike(const StateVector& from, const StateVector& to) const;
  bool hardly_moves(long first, long last, int samples) const;
  long waiting() const;
  long before(const Probe& probe) const;
  JointVector sample_noise() const;
  JointVector tolerated(const JointVector& error) const;
  bool complete() const;

  /// A sample of a probe, or one that was taken in passing.
  struct Sample {
    std::optional<Probe> probe;
    Derivative measured;
  };
  Absorbed absorb(const Sample& sample);
  bool over_budget();
  void keep(const Sample& sample);
  void learn(const Sample& sample, long k);
  void tune_grown(std::optional<int> column);
  void count(const TuneResult& result);
  void widen();
  void replay();

  LearningSetup setup_;
  Belief belief_;
  RandomStream random_;
  long period_calls_, monitor_calls_ = 0;
  History history_;
  std::optional<Probe> probe_;
  int last_probed_ = Probe::kDrift - 1;  // so that the drift has the first turn
  long next_instant_ = 0, next_passing_ = 0;
  long used_ = 0;                         // samples before this call have been learned from
  long probe_wait_ = 0;                   // calls of the running probe that its input needs to settle,
  long probe_lead_ = 0;                   // after so many at which all inputs are 0
  std::optional<WindowSample> best_;      // sample of the running probe so far
  std::optional<WindowSampler> windows_;  // none: three samples
  TimingEstimate timing_;
  TimingEstimate untimed_;          // without the running probe
  bool passes_ = false;             // q'' is learned in passing: nothing is probed
  std::optional<bool> probe_told_;  // the running probe was asked, and told
  int timed_probes_ = 0;            // that told of the timing,
  int asked_probes_ = 0;            // of so many that were asked
  BeliefMarginals believed_;        // at the last call
  std::vector<Sample> samples_;     // of this run, where there is a monitor and no process is over budget
  Belief begun_;                    // what it began with, likewise
  int capacity_ = 0;                // samples that a process may gain
  std::vector<int> tuned_size_;     // samples of a process when it was last tuned
  std::optional<SurpriseTest> test_;
  LearningRecord record_;
};

}  // namespace bayesctrl
