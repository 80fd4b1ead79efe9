#pragma once

#include "base/fields.hpp"

namespace bayesctrl {

/// All that the diagnosis takes for granted: thresholds, sizes and steps, declared once with unit and reason. They are
/// part of the method and not of a spec: chosen on seeds that no reported figure uses, the same for every machine.
/// `bayesctrl list settings` and `provenance.json` show them; docs/diagnosis.md says where each one acts.

/// A recording.
struct RecordingSettings {
  double gap_periods = 8.0;
  double longest_pause = 3e7;
  double longest_share = 1e3;
  int fewest_samples = 8;
  double least_duration = 1.0;
  double least_samples = 60.0;
  double least_motion = 5.0;
  double searched = 90.0;
  double excerpt = 10.0;
  double compared = 180.0;
  double whole = 80'000.0;
  std::size_t numbers = 12'000'000;
  std::size_t pieces = 32;
  double temperature = 1.0;

  static void fields(auto& self, auto&& field) {
    field("gap_periods", self.gap_periods,
          {kPositive, "sample periods", "a longer pause between samples is a gap: no run goes across"});
    field("longest_pause", self.longest_pause,
          {kPositive, "s", "between samples, a year: a longer one is a clock that was set"});
    field(
        "longest_share", self.longest_share,
        {kPositive, "times", "what was recorded, if it is as long as that, too: the unit of the time may be another"});
    field("fewest_samples", self.fewest_samples,
          {kPositive, "samples", "in a file: sixth differences, which measure the noise, need seven"});
    field("least_duration", self.least_duration,
          {kPositive, "s", "of all recordings together: less is too_little_data"});
    field("least_samples", self.least_samples,
          {kPositive, "samples", "of all recordings together: less is too_little_data"});
    field("least_motion", self.least_motion,
          {kPositive, "noise, RMS", "a joint has to move by that much, else nothing can be learnt"});
    field("searched", self.searched,
          {kPositive, "s", "of all recordings together: of more, excerpts of that much are searched"});
    field("excerpt", self.excerpt, {kPositive, "s", "of each, evenly spread"});
    field("compared", self.compared,
          {kPositive, "s", "of longer recordings the free runs of the fit are made in excerpts"});
    field("whole", self.whole,
          {kPositive, "samples",
           "of excerpts, about that many, are searched as they are where thinned ones are too coarse"});
    field("numbers", self.numbers,
          {kPositive, "numbers",
           "of a file are read; of more, pieces of rows, evenly spread, of all together that much"});
    field("pieces", self.pieces, {kPositive, "pieces", "of so long a file are read, or half as many"});
    field("temperature", self.temperature,
          {kPositive, "s", "over which a temperature is averaged: its sensors are coarse, and machines warm slowly"});
  }
};

/// The motion and what moves it.
struct MotionSettings {
  double segment = 2.0;
  double fastest_mode = 10.0;
  double bandwidth = 2.5;
  double samples_per_period = 20.0;
  double thinning = 1.0;
  double thinning_share = 1e-3;
  int polynomial_modes = 4;
  double intensity_range = 40.0;
  double prior_share = 0.2;
  double forcing_part = 4e-3;
  double most_forcing_parts = 3.0;
  double hidden_state_step = 0.01;
  double rest = 0.5;
  double still = 3.0;

  static void fields(auto& self, auto&& field) {
    field("segment", self.segment,
          {kPositive, "s",
           "of a segment whose initial state is free, for motions up to fastest_mode: chaos and unknown torques stay "
           "small within"});
    field(
        "fastest_mode", self.fastest_mode,
        {kPositive, "Hz", "cosines up to here hold what mechanics does, at least; what is faster measures the noise"});
    field("bandwidth", self.bandwidth,
          {kPositive, "mean frequencies", "of the motion: faster machines have faster modes and shorter segments"});
    field("samples_per_period", self.samples_per_period,
          {kPositive, "samples", "of the fastest mode that the search keeps; the rest is thinned out"});
    field("thinning", self.thinning,
          {kPositive, "noise, squares",
           "by which that may move simulations of a recording: evidence counts in ten times as much"});
    field("thinning_share", self.thinning_share,
          {kPositive, "",
           "of what the nominal leaves, by which it may move them: a third of what is listed as an effect"});
    field("polynomial_modes", self.polynomial_modes,
          {kPositive, "", "1, t, t^2, t^3 of a segment: what cosines are slow to sum up"});
    field(
        "intensity_range", self.intensity_range,
        {kPositive, "nats",
         "about the intensity of process noise at which it weighs as much as the sensor's: within that it is sought"});
    field("prior_share", self.prior_share,
          {kPositive, "",
           "standard deviation of what an effect may do, at least, as part of the RMS acceleration that the nominal's "
           "torques give"});
    field("forcing_part", self.forcing_part,
          {kPositive, "s", "torques are evaluated in the middle of parts of a step of about this length"});
    field("most_forcing_parts", self.most_forcing_parts, {kPositive, "", "at most so many of them"});
    field("hidden_state_step", self.hidden_state_step,
          {kPositive, "s", "longest step of hidden states along a known motion"});
    field("rest", self.rest,
          {kPositive, "s", "for which a joint has to be still to be at rest, where dry friction holds"});
    field("still", self.still, {kPositive, "sd", "of the velocity, within which it cannot be told from none"});
  }
};

/// Fits by free runs.
struct FitSettings {
  double least_gain = 0.1;
  double least_relative_gain = 1e-3;
  int trials = 5;
  int linear_iterations = 8;
  int exact_iterations = 6;
  int rough_iterations = 2;
  int rounds = 3;
  double hopeless = 3.0;
  double behind = 1.5;
  double shortest_step = 6e-4;
  double numerical_share = 0.05;
  double jitter = 1.1;
  double noise_deviations = 1.0;
  double astray = 3.0;
  int one_astray_of = 3;
  double recovered = 0.5;
  int segment_iterations = 8;
  int free_run_iterations = 6;
  int segment_trials = 6;
  double segment_damping = 1e-6;
  double segment_growth = 30.0;
  double segment_gain = 1e-3;
  double kept_jacobian = 0.05;
  int linear_hold_pieces = 4;
  int intensity_rounds = 3;
  int whitened_iterations = 8;
  int whitened_trials = 4;
  double whitened_gain = 0.01;
  double remainder_step = 5e-3;

  static void fields(auto& self, auto&& field) {
    field("least_gain", self.least_gain,
          {kPositive, "nats", "an iteration that gains less is the last: a tenth of what one sd is worth"});
    field("least_relative_gain", self.least_relative_gain,
          {kPositive, "", "or less than this part of half the SSE beyond the noise"});
    field("trials", self.trials, {kPositive, "", "dampings that are tried in one iteration"});
    field("linear_iterations", self.linear_iterations, {kPositive, "", "with the Jacobian of the linear response"});
    field("exact_iterations", self.exact_iterations, {kPositive, "", "with that of the machine's own free runs"});
    field("rough_iterations", self.rough_iterations,
          {kPositive, "", "or of a fit that is hopeless but the best so far"});
    field("rounds", self.rounds, {kPositive, "", "of linear iterations and polished initial states"});
    field("hopeless", self.hopeless,
          {kPositive, "SSE of noise", "a fit that leaves more is not worth many exact Jacobians"});
    field("behind", self.behind, {kPositive, "SSE of the best", "and one that leaves more than this not even a few"});
    field("shortest_step", self.shortest_step, {kPositive, "s", "of the integration"});
    field("numerical_share", self.numerical_share,
          {kPositive, "noise, RMS", "by which half the step of the integration may move a run"});
    field("jitter", self.jitter, {kPositive, "sample periods", "that one step of the integration may take"});
    field("noise_deviations", self.noise_deviations,
          {kPositive, "sd", "of the SSE of pure noise: what leaves no more fits"});
    field("astray", self.astray,
          {kPositive, "SSE of noise", "a segment that leaves more may have a wrong initial state"});
    field("one_astray_of", self.one_astray_of,
          {kPositive, "segments", "if at most one of so many does: else the model is wrong"});
    field(
        "recovered", self.recovered,
        {kPositive, "",
         "part of the SSE below which new initial states must bring it, for the parameters to be adjusted once more"});
    field("segment_iterations", self.segment_iterations, {kPositive, "", "of Levenberg-Marquardt on an initial state"});
    field("free_run_iterations", self.free_run_iterations,
          {kPositive, "", "the same for the windows of free runs that `fit` reports"});
    field("segment_trials", self.segment_trials, {kPositive, "", "dampings that are tried in one of them"});
    field("segment_damping", self.segment_damping, {kPositive, "", "at first"});
    field("segment_growth", self.segment_growth,
          {kPositive, "", "of the damping after a failure: six trials span from none to a step of a twentieth"});
    field("segment_gain", self.segment_gain,
          {kPositive, "", "part of the SSE: no iteration that promises or gains less is worth its runs"});
    field("kept_jacobian", self.kept_jacobian,
          {kPositive, "", "part of its promise by which a step may miss it for the Jacobian to be kept"});
    field("linear_hold_pieces", self.linear_hold_pieces, {kPositive, "", "of a step whose input is a straight line"});
    field("intensity_rounds", self.intensity_rounds,
          {kPositive, "", "of the intensity of process noise and the parameters"});
    field("whitened_iterations", self.whitened_iterations, {kPositive, "", "of parameters with process noise"});
    field("whitened_trials", self.whitened_trials, {kPositive, "", "dampings that are tried in one of them"});
    field("whitened_gain", self.whitened_gain, {kPositive, "nats", "an iteration that gains less is the last"});
    field("remainder_step", self.remainder_step,
          {kPositive, "s", "longest step of runs with a remainder, whose terms can be steep"});
  }
};

/// The search over sets of effects.
struct SearchSettings {
  double expected_effects = 2.0;
  double most_likely = 0.2;
  int most_effects = 3;
  int largest_set = 8;
  int grown = 3;
  double worth_growing = 0.1;
  double near = 1.0;
  int kept_findings = 100;
  int beam = 40;
  int most_columns = 24;
  int most_rests = 12;
  double most_frequencies = 1500.0;
  double sensor_prior = 0.2;
  int fitted_findings = 8;
  int findings_along_motion = 24;
  int stands_along_motion = 2;
  double usual_rows = 700.0;
  double most_effort = 5.0;
  int neighbours = 6;
  double numerical_floor = 1e-5;
  double fewest_fast_rows = 200.0;
  double least_noise_ratio = 0.5;
  double most_noise_ratio = 1.5;
  double hopeless = 40.0;
  double screen_error = 1e-3;
  double possible = 6.0;
  double promise_error = 0.05;
  double pair = 0.5;
  double most = 0.01;
  double stuck = 1.5;
  double as_much = 0.3;
  int restarts = 2;
  double restarts_below = 10.0;
  double entangled = 0.9;
  int most_entangled = 4;
  double relinearise = 1e-3;
  double coarse = 0.7;
  double least_gain = 1.0;
  double least_relative_gain = 0.005;
  double far_off = 3.0;
  int rounds = 3;
  int kept_sets = 5;
  int small_sets = 3;
  int additions = 3;
  int adjustments = 6;
  double per_effect = 0.1;
  double per_number = 0.22;
  double second_law = 0.3;
  int subsets_of = 4;
  double close = 20.0;
  int finalists = 6;
  double nested = 2000.0;
  double convergence = 0.5;
  double lost = 10.0;
  double irreplaceable = 0.05;

  static void fields(auto& self, auto&& field) {
    field("expected_effects", self.expected_effects,
          {kPositive, "", "a machine has, before anything is known: all that may be, in any joint, share them"});
    field("most_likely", self.most_likely,
          {kPositive, "probability", "of an effect before anything is known, at most"});
    field("most_effects", self.most_effects, {kPositive, "", "in a set that the screen looks at"});
    field("largest_set", self.largest_set, {kPositive, "", "effects, that grows from those by one at a time"});
    field("grown", self.grown, {kPositive, "", "triples that the screen lets grow"});
    field("worth_growing", self.worth_growing,
          {kPositive, "", "of the error beyond the noise that an effect more has to take away"});
    field("near", self.near, {kPositive, "noise", "unless less is left"});
    field("kept_findings", self.kept_findings, {kPositive, "", "pairs, and triples, that the screen returns"});
    field("beam", self.beam, {kPositive, "", "pairs that it extends to triples"});
    field("most_columns", self.most_columns, {kPositive, "", "of one set in the screen"});
    field("most_rests", self.most_rests,
          {kPositive, "", "of a joint, the longest, at each of which dry friction may hold another torque"});
    field("most_frequencies", self.most_frequencies,
          {kPositive, "",
           "of a periodic disturbance that are tried: of more, those that are strongest in the missing torque"});
    field("sensor_prior", self.sensor_prior,
          {kPositive, "rad, and part of a scale", "prior standard deviation of a sensor's offset and scale"});
    field("fitted_findings", self.fitted_findings, {kPositive, "", "of the screen, at least"});
    field("findings_along_motion", self.findings_along_motion,
          {kPositive, "", "of the screen that are fitted along the motion where those leave much"});
    field("stands_along_motion", self.stands_along_motion,
          {kPositive, "", "sets of each size from which that search goes on"});
    field("usual_rows", self.usual_rows,
          {kPositive, "",
           "of a response: with fewer the search is as much more thorough, since fits are as much faster"});
    field("most_effort", self.most_effort, {kPositive, "", "times the usual, at most"});
    field("neighbours", self.neighbours, {kPositive, "", "of the best set that are fitted in each round"});
    field("numerical_floor", self.numerical_floor,
          {kPositive, "of the motion, RMS", "noise that stands for arithmetic where a recording has none"});
    field("fewest_fast_rows", self.fewest_fast_rows,
          {kPositive, "", "modes faster than mechanics from which the noise may be estimated anew"});
    field("least_noise_ratio", self.least_noise_ratio, {kPositive, "", "where it changes by no more than to this"});
    field("most_noise_ratio", self.most_noise_ratio, {kPositive, "", "or to that part of itself"});
    field("hopeless", self.hopeless,
          {kPositive, "nats", "behind the best, beyond which a finding of the screen is not fitted"});
    field("screen_error", self.screen_error,
          {kPositive, "", "and of the nats that the best explains: the screen is linear"});
    field("possible", self.possible,
          {kPositive, "nats", "behind a good fit, beyond which an effect more is not fitted"});
    field(
        "promise_error", self.promise_error,
        {kPositive, "", "part of what an effect explains by which its linear response may miss what takes its place"});
    field("pair", self.pair,
          {kPositive, "SSE of the best single one", "two effects that promise to leave less are fitted at once"});
    field("most", self.most,
          {kPositive, "SSE of the nominal", "a set that leaves less is improved about its own motion first"});
    field("stuck", self.stuck,
          {kPositive, "SSE that the linear response promises",
           "a part of the best that leaves more is fitted once more from there"});
    field("as_much", self.as_much,
          {between(0.0, 1.0), "SSE",
           "at least, and at most its inverse: the process noise that a fit leaves serves another"});
    field(
        "entangled", self.entangled,
        {between(0.0, 1.0), "", "correlation of two numbers, from which on others are tried in their effects' place"});
    field("most_entangled", self.most_entangled, {kPositive, "", "such effects or pairs of them, the most entangled"});
    field("relinearise", self.relinearise,
          {kPositive, "p-value", "of the best, below which the motion is linearised about it"});
    field("coarse", self.coarse,
          {kPositive, "",
           "what a set leaves of whole recordings less than that of what it leaves of thinned ones: these are too "
           "coarse"});
    field("least_gain", self.least_gain, {kPositive, "nats", "a round that gains less is the last"});
    field("least_relative_gain", self.least_relative_gain, {kPositive, "", "or less than this part of half the SSE"});
    field("far_off", self.far_off,
          {kPositive, "noise, RMS",
           "left by the best: its motion is no better than the smoothed one, and simple sets are wanted too"});
    field("rounds", self.rounds, {kPositive, "", "of linearisation"});
    field("kept_sets", self.kept_sets, {kPositive, "", "best ones that are fitted again about another motion"});
    field("small_sets", self.small_sets, {kPositive, "", "that are enlarged by one simple effect"});
    field("additions", self.additions, {kPositive, "", "to each of them"});
    field("adjustments", self.adjustments, {kPositive, "", "iterations of free parameters along the smoothed motion"});
    field("per_effect", self.per_effect,
          {kPositive, "nats of error",
           "by which one effect more has to lower the logarithm of the error where models are wrong: a tenth"});
    field("per_number", self.per_number, {kPositive, "nats of error", "and one number more: a fifth"});
    field("second_law", self.second_law,
          {kPositive, "of the first", "level at which a second law of dry friction starts"});
    field("subsets_of", self.subsets_of, {kPositive, "", "best candidates whose subsets are all fitted"});
    field("close", self.close, {kPositive, "nats", "behind the best, within which fits are brought to their optima"});
    field("finalists", self.finalists, {kPositive, "", "this many of them"});
    field("nested", self.nested, {kPositive, "nats", "and what the best contains, within these"});
    field("convergence", self.convergence, {kPositive, "nats", "that a new start has to gain"});
    field("lost", self.lost,
          {kPositive, "SSE of the best",
           "a set that leaves more is not fitted about the next motion, nor after one step from a set that holds it"});
    field("irreplaceable", self.irreplaceable,
          {kPositive, "of the squares that an effect does",
           "left by the others in its place: a part that lacks it is as lost"});
  }
};

/// What no effect explains.
struct DiscrepancySettings {
  int rbfs = 36;
  int fine_rbfs = 72;
  int state_rbfs = 7;
  int product_rbfs = 18;
  int past_rbfs = 12;
  double time_step = 0.1;
  double slow_time_step = 3.0;
  double most_times = 400.0;
  double change_step = 0.25;
  int relays = 12;
  double slowest_swing = 4.0;
  double fastest_swing = 40.0;
  double rare = 0.05;
  double slow = 0.01;
  int effect_shapes = 8;
  int compared_groups = 3;
  double explains_all = 0.02;
  double history_gain = 5.0;
  int folds = 3;
  double evident = 2.0;
  double nearly_all = 0.999;
  double negligible = 1e-4;
  int most_groups = 4;
  double beyond = 3.0;
  double group_gain = 0.8;
  double worthwhile = 0.02;
  double per_effects = 0.1;
  double per_group = 0.22;
  double many_terms = 0.1;
  double enough = 1.03;
  int most_windows = 40;
  double coarse_step = 4e-3;
  double no_imitation = 0.1;
  double imitates_all = 0.98;
  double carried = 3.0;

  static void fields(auto& self, auto&& field) {
    field("rbfs", self.rbfs, {kPositive, "", "radial basis functions along each quantity"});
    field("fine_rbfs", self.fine_rbfs, {kPositive, "", "the same where edges are sharp"});
    field("state_rbfs", self.state_rbfs, {kPositive, "", "along each side of the grid over position and velocity"});
    field("product_rbfs", self.product_rbfs, {kPositive, "", "along the first of two causes"});
    field("past_rbfs", self.past_rbfs, {kPositive, "", "along what is remembered, for each time constant"});
    field("time_step", self.time_step, {kPositive, "s", "between centres in the time that all recordings share"});
    field("slow_time_step", self.slow_time_step, {kPositive, "s", "between centres in the time of one recording"});
    field("most_times", self.most_times, {kPositive, "", "centres in time at most"});
    field("change_step", self.change_step,
          {kPositive, "s", "between centres in time of what changes a gain or a drag"});
    field("relays", self.relays, {kPositive, "", "along the positions"});
    field("slowest_swing", self.slowest_swing, {kPositive, "rad/s", "of masses on springs that are carried along"});
    field("fastest_swing", self.fastest_swing, {kPositive, "rad/s", "and the fastest"});
    field("rare", self.rare, {kPositive, "of the samples", "on either side of where fine terms lie"});
    field("slow", self.slow, {kPositive, "of the highest speed", "over which dry friction is smooth"});
    field("effect_shapes", self.effect_shapes,
          {kPositive, "", "of each effect that are weighed against a discrepancy"});
    field("compared_groups", self.compared_groups, {kPositive, "", "of discrepancy that effects are weighed against"});
    field("explains_all", self.explains_all,
          {kPositive, "", "part of the variance that a cause may leave which explains all"});
    field("history_gain", self.history_gain,
          {kPositive, "SSE per term", "that the past has to explain beyond the present"});
    field("folds", self.folds, {kPositive, "", "parts of the recordings that are left out in turn"});
    field("evident", self.evident, {kPositive, "sd", "beyond which the squares of a part are more than noise"});
    field("nearly_all", self.nearly_all,
          {kPositive, "", "and of these one recording may hold no more, else every third segment is left out"});
    field("negligible", self.negligible, {kPositive, "of the largest", "a weight below that is dropped"});
    field("most_groups", self.most_groups, {kPositive, "", "of terms in a remainder"});
    field("beyond", self.beyond,
          {kPositive, "largest torque seen", "what a parametric group may give where it extrapolates"});
    field("group_gain", self.group_gain,
          {kPositive, "", "part of the left-out SSE below which one group more has to bring it"});
    field("worthwhile", self.worthwhile,
          {kPositive, "nats of error", "that a larger model has to gain in left-out free runs"});
    field("per_effects", self.per_effects,
          {kPositive, "nats of error", "one with effects in the place of a remainder alone"});
    field("per_group", self.per_group, {kPositive, "nats of error", "a remainder of one group more"});
    field("many_terms", self.many_terms, {kPositive, "nats of error", "and one that is not parametric"});
    field("enough", self.enough, {kPositive, "noise, RMS", "no model can do much better"});
    field("most_windows", self.most_windows, {kPositive, "", "of free runs by which models are compared"});
    field("coarse_step", self.coarse_step, {kPositive, "s", "with this step of the integration, at least"});
    field("no_imitation", self.no_imitation,
          {kPositive, "of the SSE",
           "that others leave: time and the past can imitate other causes, and count where they leave less"});
    field("imitates_all", self.imitates_all, {kPositive, "", "unless those explain this much"});
    field("carried", self.carried,
          {kPositive, "error",
           "of a part with the parameters of the others: effects that do worse are not carried by all recordings"});
  }
};

/// Mistakes of the spec or of a recording.
struct DoubtSettings {
  double samples = 4000.0;
  double noise_share = 0.01;
  double widest = 0.02;
  double slow = 0.1;
  double worth_a_look = 0.5;
  double explains = 0.5;
  double near_best = 3.0;
  double any_number = 0.8;
  double gross = 0.2;
  double near_nothing = 0.1;
  double adequate = 2.0;
  int most = 4;
  double prior = 5.0;
  double per_number = 5.0;
  double certain = 20.0;
  double far_better = 3.0;
  double other_size = 3.0;
  double other_unit = 10.0;
  double input_off = 0.05;
  double undone = 0.01;
  double matters = 0.05;
  double some_answer = 0.5;
  double edge = 0.02;
  double spike = 8.0;
  double stuck = 4.0;

  static void fields(auto& self, auto&& field) {
    field("samples", self.samples, {kPositive, "samples", "of the recordings, evenly spread, that rank mistakes"});
    field("noise_share", self.noise_share, {kPositive, "", "of squared accelerations that may be the sensor's noise"});
    field("widest", self.widest, {kPositive, "of a stretch without a gap", "over which accelerations are smoothed"});
    field("slow", self.slow, {kPositive, "RMS speed", "over which dry friction is smooth"});
    field("worth_a_look", self.worth_a_look,
          {kPositive, "",
           "of what the nominal leaves of the accelerations: a mistake that leaves more is not looked at"});
    field("explains", self.explains, {kPositive, "", "of the accelerations themselves, likewise"});
    field("near_best", self.near_best, {kPositive, "", "times what the best leaves of them, likewise"});
    field("any_number", self.any_number,
          {kPositive, "", "of what a change of units leaves, beyond which a number that may be any is not looked at"});
    field("gross", self.gross,
          {kPositive, "", "of the accelerations, unexplained by the nominal with friction: mistakes are looked for"});
    field("near_nothing", self.near_nothing,
          {kPositive, "", "of that, what a mistake leaves that physics can only imitate"});
    field("adequate", self.adequate,
          {kPositive, "noise, RMS", "left without a mistake at most, where physics was not searched beside it"});
    field("most", self.most, {kPositive, "", "mistakes that are looked at"});
    field("prior", self.prior, {kPositive, "nats", "against any one mistake"});
    field("per_number", self.per_number, {kPositive, "nats", "against each number of an explanation"});
    field("certain", self.certain, {kPositive, "nats", "by which a mistake is more probable than physics: check_spec"});
    field("far_better", self.far_better, {kPositive, "", "times less error than the best physics leaves, likewise"});
    field("other_unit", self.other_unit,
          {kPositive, "", "a parameter that is wrong by more than that is in another unit"});
    field("other_size", self.other_size, {kPositive, "", "an input stronger or weaker than that is no physics"});
    field("input_off", self.input_off,
          {kPositive, "", "of the input's squares: an explanation that leaves less is none"});
    field("undone", self.undone,
          {kPositive, "", "of the squares of a term of the model: an explanation that leaves less of it is none"});
    field("matters", self.matters,
          {kPositive, "", "of the accelerations, squares, what an input, or a term, has to be good for"});
    field("some_answer", self.some_answer,
          {kPositive, "", "of what no input leaves: one that explains more is answered, however regular it is"});
    field("edge", self.edge, {kPositive, "of its range", "from its end, where a parameter is not credible"});
    field("spike", self.spike, {kPositive, "", "times the usual, what one sample has to jump by"});
    field("stuck", self.stuck, {kPositive, "", "times the usual, what a sensor has to jump by when it comes loose"});
  }
};

/// The verdict.
struct VerdictSettings {
  double significant = 1e-4;
  double nothing = 1e-5;
  double material = 0.1;
  double immaterial = 1e-2;
  double unseen = 1e-3;
  double trace = 0.003;
  double above_remainder = 5.0;
  double imitable = 0.06;
  double part_of_remainder = 2.0;
  double alone = 0.98;
  double rebounds = 1e-3;
  double never_acts = 0.1;
  int most_equivalents = 3;
  double listed = 0.01;
  double same_law = 0.02;
  double earned = 10.0;
  double confident = 0.9;
  double likely = 0.5;
  double inseparable = 3.0;
  double held_out = 1.3;
  double held_out_share = 0.15;
  double held_out_more = 3.0;
  double unheld = 0.7;
  double adequate = 3.0;
  double little = 0.003;
  double knows_better = 10.0;
  double shows_in_time = 5.0;
  double imperfect = 2.0;
  int compared_sets = 15;
  int many_more = 2;
  double contradicted = 1.1;
  double band = 3.0;
  double departed = 5.0;
  double shortest = 0.05;
  double merge_torque = 0.3;
  double merge_motion = 0.1;
  int replicates = 199;
  int autocorrelation_lags = 12;
  int input_lags = 10;
  double longest_lag = 0.5;
  double rival = 1e-3;
  double experiment = 10.0;
  double experiment_period = 0.01;
  double shown_period = 0.02;
  double further = 2.0;
  int imitation_iterations = 5;
  double simulation_step = 1.4e-3;
  double shown_alternative = 1e-4;
  int most_alternatives = 10;

  static void fields(auto& self, auto&& field) {
    field("significant", self.significant,
          {kPositive, "p-value", "of what the best explanation leaves (F test), below which something is left"});
    field("nothing", self.nothing,
          {kPositive, "p-value", "of the nominal, below which something is missing although no effect explains it"});
    field("material", self.material,
          {kPositive, "of the refit nominal's error",
           "that the remainder takes away, beyond which the verdict is unknown"});
    field("immaterial", self.immaterial,
          {kPositive, "of the refit nominal's error", "which a part of an explanation has to take away to be listed"});
    field("unseen", self.unseen,
          {kPositive, "likewise", "where the explanation with that part leaves no more than noise"});
    field("trace", self.trace,
          {kPositive, "of the error, squares", "without it: an effect of a smaller share is told as a trace"});
    field("above_remainder", self.above_remainder,
          {kPositive, "of what is left, squares", "which an effect has to take away to be named beside it"});
    field("imitable", self.imitable,
          {kPositive, "of the refit nominal's error, squares",
           "left of what is not named, beyond which effects may imitate what is missing"});
    field("part_of_remainder", self.part_of_remainder,
          {kPositive, "of what is left, squares", "which an effect has to take away there to be certain"});
    field("alone", self.alone,
          {between(0.0, 1.0), "of the mismatch, squares",
           "that one effect alone has to take away to be told in `alone`"});
    field("rebounds", self.rebounds,
          {kPositive, "of squared velocities", "the other way, with which a joint still moves one way only"});
    field("never_acts", self.never_acts,
          {kPositive, "nats",
           "by which an effect changes the evidence at most, beside its penalty, that does nothing there"});
    field("same_law", self.same_law,
          {kPositive, "", "by which dry friction is at least stronger at rest, else it is the simpler law"});
    field("listed", self.listed, {kPositive, "probability", "of inclusion, beyond which an effect is listed there"});
    field("earned", self.earned, {kPositive, "nats", "by which effects beside a remainder have to beat it alone"});
    field("confident", self.confident, {kPositive, "probability", "of inclusion of each effect that is named"});
    field("likely", self.likely, {kPositive, "probability", "and of the set, below which it is ambiguous"});
    field("held_out", self.held_out,
          {kPositive, "noise, RMS", "left of held-out recordings, beyond which an explanation may not hold"});
    field("held_out_share", self.held_out_share,
          {kPositive, "of the refit nominal's error", "left there as well: it does not hold"});
    field("held_out_more", self.held_out_more,
          {kPositive, "", "times what it leaves of the recordings that it was made from, likewise"});
    field("unheld", self.unheld, {kPositive, "probability", "of each of its effects then, at most"});
    field("adequate", self.adequate, {kPositive, "noise, RMS", "left by an explanation that is one in any case"});
    field("little", self.little, {kPositive, "of the motion, RMS", "left, likewise"});
    field("knows_better", self.knows_better,
          {kPositive, "", "by which another has to err less than a curve that knows no physics"});
    field("shows_in_time", self.shows_in_time,
          {kPositive, "nats", "by which an effect in time has to improve free runs twice, or of what was held out"});
    field("most_equivalents", self.most_equivalents,
          {kPositive, "", "names of one effect, the most probable: more would be none"});
    field("inseparable", self.inseparable,
          {kPositive, "nats", "within which effects that replace each other are observationally equivalent"});
    field("imperfect", self.imperfect,
          {kPositive, "noise, RMS", "left by the best explanation, beyond which no model is taken to be right"});
    field("compared_sets", self.compared_sets, {kPositive, "", "that free runs compare where models are imperfect"});
    field("many_more", self.many_more,
          {kPositive, "numbers", "a set with more than these beyond the best is no alternative to it"});
    field("contradicted", self.contradicted,
          {kPositive, "error",
           "of free runs: parameters with process noise that make it larger are not taken, nor a remainder that does "
           "where it is held out"});
    field("band", self.band, {kPositive, "sd", "of the missing torque, beyond which it is significant"});
    field("departed", self.departed, {kPositive, "noise", "between a recording and a simulation"});
    field("shortest", self.shortest, {kPositive, "s", "of an interval of missing torque"});
    field("merge_torque", self.merge_torque, {kPositive, "s", "between intervals of missing torque that count as one"});
    field("merge_motion", self.merge_motion, {kPositive, "s", "and of departed motion"});
    field("replicates", self.replicates, {kPositive, "", "of white noise in the tests of the residual"});
    field("autocorrelation_lags", self.autocorrelation_lags, {kPositive, "samples", "of Ljung and Box's test"});
    field("input_lags", self.input_lags, {kPositive, "", "on each side, of the correlation with the input"});
    field("longest_lag", self.longest_lag, {kPositive, "s", "the last of them"});
    field("rival", self.rival, {kPositive, "probability", "of an explanation that is worth an experiment"});
    field("experiment", self.experiment, {kPositive, "s", "of a proposed input"});
    field("experiment_period", self.experiment_period, {kPositive, "s", "of its samples"});
    field("shown_period", self.shown_period, {kPositive, "s", "of its samples in the report"});
    field("further", self.further, {kPositive, "way in the recordings", "no experiment leads further"});
    field("imitation_iterations", self.imitation_iterations, {kPositive, "", "of the rival's parameters"});
    field("simulation_step", self.simulation_step, {kPositive, "s", "longest step of `bayesctrl simulate`"});
    field("shown_alternative", self.shown_alternative, {kPositive, "probability", "of an alternative that is listed"});
    field("most_alternatives", self.most_alternatives, {kPositive, "", "at most"});
  }
};

struct Settings {
  RecordingSettings recording;
  MotionSettings motion;
  FitSettings fit;
  SearchSettings search;
  DiscrepancySettings discrepancy;
  DoubtSettings doubt;
  VerdictSettings verdict;

  static void fields(auto& self, auto&& field) {
    field("recording", self.recording, {.text = "a recording"});
    field("motion", self.motion, {.text = "the motion and what moves it"});
    field("fit", self.fit, {.text = "fits by free runs"});
    field("search", self.search, {.text = "the search over sets of effects"});
    field("discrepancy", self.discrepancy, {.text = "what no effect explains"});
    field("doubt", self.doubt, {.text = "mistakes of the spec or of a recording"});
    field("verdict", self.verdict, {.text = "the verdict"});
  }
};

inline constexpr Settings kSettings{};

}  // namespace bayesctrl
