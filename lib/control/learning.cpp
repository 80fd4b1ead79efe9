#include "control/learning.hpp"

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace bayesctrl {

namespace {

constexpr long kRest = 5;             // times the length of a probe, until the next
constexpr int kLeastTuned = 3;        // samples of a process that are tuned after an alarm
constexpr int kTimedProbes = 8;       // for each joint, that tell of the timing
constexpr int kAskedProbes = 16;      // for each joint, after which none is probed for its timing alone
constexpr long kBeforeProbe = 6;      // calls before a probe that show its jump
constexpr long kMostReserved = 4000;  // samples that there is room for from the start
constexpr double kVagueGain = 10.0;   // thresholds: until that much is known of b it is probed,
constexpr double kLostGain = 25.0;    // and again where the machine has come to where so little is known
constexpr double kAlike = 0.999;      // correlation of the drift at states that may stand for each other

}  // namespace

Learning::Learning(LearningSetup setup, Belief belief, RandomStream random)
    : setup_(std::move(setup)),
      belief_(std::move(belief)),
      random_(random),
      period_calls_(std::max(1L, std::lround(setup_.learner.period / setup_.control_period))) {
  // What is learned in passing is measured over a window.
  if (setup_.learner.monitor && !setup_.learner.window) setup_.learner.window.emplace();
  const int n = belief_.joints();
  const double dt = setup_.control_period;
  long capacity = 4, more = setup_.calls / std::max(3L, period_calls_) + 2;
  if (const auto& window = setup_.learner.window) {
    windows_.emplace(*window, setup_.learner.monitor.has_value(), n, dt, setup_.positions_only);
    timing_ = setup_.timings ? TimingEstimate(*setup_.timings)
                             : TimingEstimate(n, window->longest_delay, dt, setup_.positions_only);
    const long late = std::lround(std::ceil(std::max(window->longest_delay, latest(timing_.best()).together()) / dt));
    capacity = 2L * windows_->longest() + 12 * late + kBeforeProbe + 2L * setup_.learner.hold_periods + 8;
  }
  if (const auto& monitor = setup_.learner.monitor) {
    monitor_calls_ = std::max(1L, std::lround(monitor->period / dt));
    more += setup_.calls / monitor_calls_ + 1;
    test_.emplace(monitor->false_alarm_rate);
    belief_.join();
    begun_ = belief_;
    record_.monitored = true;
  }
  history_ = History(n, static_cast<int>(capacity));
  tuned_size_.assign(static_cast<std::size_t>(n) * static_cast<std::size_t>(n + 1), 0);
  capacity_ = static_cast<int>(std::min(more, kMostReserved));
  belief_.reserve(capacity_);
}

BeliefMarginals Learning::see(long k, const StateVector& seen, const JointVector& error) {
  history_.add(seen);
  finish_probe(k);
  pass(k);
  believed_ = belief_.predict(state(k));
  passes_ = test_ && timing_.known() && !vague(believed_);
  start_probe(error, k);
  return believed_;
}

JointVector Learning::input() const {
  const bool leading = history_.calls() - 1 < probe_->start + probe_lead_;
  return probing_input(setup_.learner, leading ? Probe{} : *probe_, belief_.joints());
}

void Learning::finish() {
  if (setup_.tuning.when == TuneWhen::at_end) {
    count(tune(belief_, setup_.tuning, random_));
    if (test_) replay();
  }
  if (windows_ && timing_.known()) record_.timings = timing_.best();
}

/// The state at call k: as it is seen or, where velocities are differences of positions so noisy that beliefs are
/// looked up where the drift is another, at the end of a window in which the acceleration's change does less.
StateVector Learning::state(long k) const {
  const StateVector& seen = history_.seen(k);
  const int samples = windows_ ? windows_->longest_probe() : 0;
  if (!test_ || !setup_.positions_only || believed_.gain_mean.size() == 0 || k < samples) return seen;
  const JointVector deviation = windows_->difference_variance().cwiseSqrt();
  StateVector moved = seen;
  moved.tail(deviation.size()) += deviation;
  if (alike(seen, moved)) return seen;
  const WindowSample last = window(k - samples + 1, samples);
  return (last.passed.cwiseAbs().array() > deviation.array()).any() ? seen : last.end;
}

void Learning::finish_probe(long k) {
  if (!probe_) return;
  const long age = k - probe_->start;
  if (!windows_) {
    if (age == 2) learn({probe_, three_samples(probe_->start)}, k);
    if (age >= setup_.learner.hold_periods) end_probe(k);
    return;
  }
  const auto seen = static_cast<int>(age - probe_lead_ - probe_wait_ + 1), most = windows_->longest_probe();
  if (seen < windows_->shortest() || age < setup_.learner.hold_periods) return;
  const bool longest = seen >= most;
  const int samples = std::min(seen, most);
  if (!timing_.known() && !longest && samples < windows_->shortest() + kBeforeProbe) return;
  if (!timing_.known() && (!probe_told_ || longest)) time_probe(k);
  WindowSample measured = window(k - samples + 1, samples);
  if (probe_->column != Probe::kDrift) add_jump(measured.derivative, k);
  if (!best_ || inaccuracy(measured.derivative) < inaccuracy(best_->derivative)) best_ = measured;
  if (inaccuracy(best_->derivative) > 1.0 && !longest) return;
  if (!longest || timing_.known()) time_probe(k);
  windows_->keep(*best_);
  learn({probe_, best_->derivative}, k);
  end_probe(k);
}

void Learning::end_probe(long k) {
  const long length = k - probe_->start;
  probe_.reset();
  best_.reset();
  probe_told_.reset();
  if (setup_.learner.schedule == Schedule::after_probe) next_instant_ = k + period_calls_;
  if (!test_) return;
  // A probe that was held longer than it had to be is followed by a longer rest: machines run away while they are
  // probed. But without b there is no control, and without timing nothing to learn in passing: until both are known
  // half of the time is spent on probes.
  const bool untimed = asks_timing() && !timing_.known();
  if (!untimed && !vague(belief_.predict(state(k)))) {
    next_instant_ = std::max(next_instant_, k + kRest * length);
  } else {
    next_instant_ = k + (complete() ? length : 0);
  }
}

/// Whether further probes are asked how late their input acts.
bool Learning::asks_timing() const {
  const int n = belief_.joints();
  return timed_probes_ < kTimedProbes * n && asked_probes_ < kAskedProbes * n;
}

/// Asks the running probe how late its input acted; what it said when it was shorter does not count any more.
void Learning::time_probe(long k) {
  if (probe_told_ ? timing_.known() : timed_probes_ >= kTimedProbes * belief_.joints()) return;
  if (probe_told_) {
    timing_ = untimed_;
    timed_probes_ -= *probe_told_;
  } else {
    untimed_ = timing_;
    ++asked_probes_;
  }
  probe_told_ = timing_.add(history_, before(*probe_), k);
  timed_probes_ += *probe_told_;
}

/// Variance of a sample, over the one that is asked for; above 1 a probe is held longer.
double Learning::inaccuracy(const Derivative& sample) const {
  if (!sample.gain) return sample.variance->maxCoeff() / std::pow(setup_.learner.window->accuracy, 2);
  const GainEstimate gain = estimate_gain(belief_, setup_.learner, *probe_, sample);
  const double value = gain.value[probe_->column], variance = gain.variance[probe_->column];
  return value > 0.0 ? variance / (asked_gain_variance(setup_.learner) * value * value) : kInfinity;
}

/// Whether too little is known of b for learning in passing.
bool Learning::vague(const BeliefMarginals& believed) const {
  bool any = false;
  for (int j = 0; j < belief_.joints(); ++j) {
    any = any || uncertain(setup_.learner, believed, j, passes_ ? kLostGain : kVagueGain);
  }
  return any;
}

/// The first call that shows the motion before a probe's jump: while all inputs were 0 where there are several.
long Learning::before(const Probe& probe) const {
  double delay = 0.0;
  for (const Timing& timing : timing_.best()) delay = std::max(delay, timing.delay);
  const long late = timing_.known() ? std::lround(delay / setup_.control_period) : waiting();
  if (probe_lead_ > 0) return probe.start + probe_wait_;
  const long as_long = std::max<long>(kBeforeProbe, windows_->samples());
  return std::max(probe.start - as_long, late);
}

/// Whether every process has a sample.
bool Learning::complete() const {
  bool all = belief_.points(0, Probe::kDrift) > 0;
  for (int j = 0; j < belief_.joints(); ++j) all = all && belief_.points(j, j) > 0;
  return all;
}

void Learning::pass(long k) {
  if (!passes_ || probe_ || k < next_passing_) return;
  const int samples = passing_samples(k);
  if (samples == 0) return;
  const long first = k - samples + 1;
  next_passing_ = k + monitor_calls_;
  const WindowSample measured = window(first, samples);
  windows_->keep(measured);
  learn({{}, measured.derivative}, k);
}

void Learning::start_probe(const JointVector& error, long k) {
  if (k < next_instant_) return;
  if (!probe_ && k < setup_.calls && !passes_) {
    std::bitset<kMaxJoints> untimed;  // inputs of which it is asked, and not known, how late they act
    const bool asks = test_ && asks_timing();
    for (int j = 0; j < belief_.joints(); ++j) untimed[static_cast<std::size_t>(j)] = asks && !timing_.known(j);
    probe_ = decide(setup_.learner, believed_, tolerated(error), last_probed_, k, untimed);
    if (probe_) last_probed_ = probe_->column;
    probe_wait_ = waiting();
    // The inputs of several joints must not jump together: before one is probed all are 0 for a while.
    const bool several = windows_ && belief_.joints() > 1 && probe_ && probe_->column != Probe::kDrift;
    probe_lead_ = several ? probe_wait_ + kBeforeProbe : 0;
  }
  next_instant_ = k + period_calls_;
}

/// Calls after its beginning at which a probe's input has settled, as far as is known.
long Learning::waiting() const {
  if (!windows_) return 0;
  const double longest = setup_.learner.window->longest_delay, dt = setup_.control_period;
  double wait = longest;
  if (timing_.known()) {
    wait = 0.0;
    for (const Timing& timing : timing_.best()) wait = std::max(wait, timing.delay + 3.0 * timing.lag);
  }
  return static_cast<long>(std::ceil(wait / dt - 1e-9));
}

/// Whether the drift is believed to be nearly the same at two states.
bool Learning::alike(const StateVector& from, const StateVector& to) const {
  double least = 1.0;
  for (int i = 0; i < belief_.joints(); ++i) {
    least = std::min(least, correlation(belief_.drift_prior(i).kernel, span_of(from), span_of(to)));
  }
  return least > kAlike;
}

/// Whether a window of so many samples may stand for those from one call to another: the drift is nearly the same in
/// the first and in the last of such windows.
bool Learning::hardly_moves(long first, long last, int samples) const {
  return alike(window(first, samples).derivative.x, window(last - samples + 1, samples).derivative.x);
}

/// Samples of a window that ends now and begins after what was learned from; 0 to wait. As few as a probe has, but
/// where the sensor is too noisy for the longest probe as many as drift_threshold asks for, while the machine hardly
/// moves.
int Learning::passing_samples(long k) const {
  const int shortest = windows_->samples();
  const int wanted =
      shortest < windows_->longest_probe()
          ? shortest
          : std::max(shortest, windows_->samples_for(setup_.learner.drift_threshold, windows_->longest()));
  const auto unused = static_cast<int>(std::min<long>(k - used_ + 1, wanted));
  if (unused < shortest) return 0;
  if (shortest == wanted || !hardly_moves(k - unused + 1, k, shortest)) return shortest;
  return unused == wanted ? wanted : 0;
}

/// Variance that a sample of each joint's drift would have.
JointVector Learning::sample_noise() const {
  JointVector noise(belief_.joints());
  for (int i = 0; i < noise.size(); ++i) noise[i] = belief_.drift_prior(i).noise_variance;
  if (windows_) noise += windows_->acceleration_variance();
  return noise;
}

/// Variance of each joint's drift that is no reason for a probe.
JointVector Learning::tolerated(const JointVector& error) const {
  JointVector variance = JointVector::Zero(belief_.joints());
  if (setup_.learner.order == ProbeOrder::in_turn) variance = sample_noise();
  const double share = setup_.learner.error_share;
  return share > 0.0 && error.size() > 0 ? JointVector(variance.cwiseMax((share * error).cwiseAbs2())) : variance;
}

Derivative Learning::three_samples(long first) const {
  const std::array<StateVector, 3> x{history_.seen(first), history_.seen(first + 1), history_.seen(first + 2)};
  return setup_.positions_only ? estimate_from_positions(x, setup_.control_period)
                               : estimate_from_states(x, setup_.control_period);
}

/// Adds the probed column of b by the jump of its input, from what was seen until call k.
void Learning::add_jump(Derivative& sample, long k) const {
  const JumpFit fit = fit_jump(history_, probe_->column, before(*probe_), k, setup_.control_period,
                               setup_.positions_only, timing_.best(), believed_.gain_mean);
  sample.gain = fit.gain;
  sample.gain_variance = JointVector::Constant(fit.gain.size(), kInfinity);
  if (fit.degrees_of_freedom == 0) return;
  sample.gain_variance =
      windows_->noise(fit.rest, fit.degrees_of_freedom).cwiseProduct(fit.factor) + fit.bias.cwiseAbs2();
}

/// By what is known of the timing and believed of b now.
WindowSample Learning::window(long first, int samples) const {
  return (*windows_)(history_, first, samples, timing_.best(), believed_.gain_mean);
}

Absorbed Learning::absorb(const Sample& sample) {
  if (sample.probe) return bayesctrl::absorb(belief_, setup_.learner, *sample.probe, sample.measured);
  const Absorbed absorbed = absorb_in_passing(belief_, setup_.learner, sample.measured);
  if (absorbed.taken > 0) ++record_.passing_samples;
  return absorbed;
}

void Learning::learn(const Sample& sample, long k) {
  const Absorbed absorbed = absorb(sample);
  used_ = k;
  if (test_) keep(sample);
  record_.refused_gain_estimates += absorbed.refused;
  record_.skipped_samples += absorbed.skipped;
  bool alarm = false;
  for (const double z : absorbed.surprises) alarm = (test_ && (*test_)(z)) || alarm;
  if (alarm) {
    record_.alarms.push_back(static_cast<double>(k) * setup_.control_period);
    widen();
  } else if (setup_.tuning.when == TuneWhen::every_sample && absorbed.taken > 0) {
    tune_grown(sample.probe ? std::optional(sample.probe->column) : std::nullopt);
  }
}

/// Tunes the processes that the last sample may have extended: those of one column, or all.
void Learning::tune_grown(std::optional<int> column) {
  const Tuning& tuning = setup_.tuning;
  bool tuned_any = false;
  auto last = tuned_size_.begin();
  belief_.for_each([&](int i, int j, Posterior& process, int term) {
    int& tuned = *last++;
    if ((column && j != *column) || process.over_budget()) return;
    const int size = belief_.points(i, j);
    const bool due = size % tuning.every == 0 && size >= tuning.growth * tuned;
    if (size < tuning.least_samples || !due || (!column && size == tuned)) return;
    tuned = size;
    tuned_any = true;
    count(tune(process, tuning.of(j), random_, term));
  });
  if (tuned_any && test_) replay();
}

void Learning::count(const TuneResult& result) {
  record_.tuning_evaluations += result.evaluations;
  record_.failed_tunings += result.failed;
}

/// After an alarm: hyper-parameters anew, and scales so wide that what was seen is no longer surprising.
void Learning::widen() {
  auto last = tuned_size_.begin();
  belief_.for_each([&](int i, int j, Posterior& process, int term) {
    const int size = *last++ = belief_.points(i, j);
    const bool enough = size >= std::max(kLeastTuned, setup_.tuning.least_samples);
    if (enough && !process.over_budget()) count(tune(process, setup_.tuning.of(j), random_, term));
  });
  for (int i = 0; i < belief_.joints(); ++i) bayesctrl::widen(belief_.motion(i));
  replay();
}

/// Whether a process has absorbed samples that it cannot give back.
bool Learning::over_budget() {
  bool any = false;
  belief_.for_each([&](int, int, const Posterior& process, int) { any = any || process.over_budget(); });
  return any;
}

/// Keeps a sample to be taken again, as long as that can be.
void Learning::keep(const Sample& sample) {
  if (over_budget()) {
    samples_ = {};
  } else {
    samples_.push_back(sample);
  }
}

/// All samples of the run anew, under the hyper-parameters of now: they are linearised where log b is believed to be.
/// Over budget what was learned stays.
void Learning::replay() {
  if (over_budget()) return;
  belief_ = belief_.with_samples(begun_);
  belief_.reserve(capacity_);
  record_.passing_samples = 0;
  for (const Sample& sample : samples_) absorb(sample);
}

}  // namespace bayesctrl
