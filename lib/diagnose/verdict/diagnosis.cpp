#include "diagnose/verdict/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "base/format.hpp"
#include "diagnose/discrepancy/decline.hpp"
#include "diagnose/recording/read_recording.hpp"
#include "diagnose/verdict/present.hpp"
#include "diagnose/verdict/propose.hpp"
#include "diagnose/verdict/where.hpp"
#include "diagnose/verdict/which.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

constexpr double kSignificant = 1e-4;       // p-value of what the best explanation leaves
constexpr double kNothing = 1e-5;           // p-value of the nominal alone, where no effect explains anything
constexpr double kWindow = 2.0;             // s, over which explanations are fitted
constexpr double kFastestMode = 10.0;       // Hz, of the mechanics, at least
constexpr double kBandwidth = 2.5;          // times the motion's mean frequency
constexpr double kSamplesPerPeriod = 20.0;  // of the fastest mode; more are thinned out for the search
constexpr double kMaterial = 0.1;           // of the refit nominal's error
constexpr double kEarned = 10.0;            // nats by which effects beside a remainder must beat it alone
constexpr double kConfident = 0.9;          // probability, below which the verdict is `ambiguous`
constexpr double kShown = 1e-4;             // probability of an alternative that is listed
constexpr double kLeastDuration = 1.0;      // s of recording
constexpr double kLeastSamples = 60.0;
constexpr double kLeastMotion = 5.0;  // of the noise, RMS: below, the machine never moved

enum class Verdict { named, nothing_missing, ambiguous, unknown, too_little_data };
constexpr std::array<std::string_view, 5> names(Verdict) {
  return {"named", "nothing_missing", "ambiguous", "unknown", "too_little_data"};
}

/// Which recordings say enough to be diagnosed; a reason where they do not.
std::string too_little(const std::vector<Measured>& data, const Eigen::VectorXd& noise) {
  double samples = 0.0, duration = 0.0;
  for (const Measured& m : data) {
    samples += static_cast<double>(m.samples());
    duration += m.time.back();
  }
  if (samples < kLeastSamples) return "only " + format(samples, 6) + " samples in all";
  if (duration < kLeastDuration) return "only " + format(duration, 3) + " s of recording in all";
  double most = 0.0;
  for (const Measured& m : data) {
    for (Eigen::Index j = 0; j < noise.size(); ++j) {
      const Eigen::ArrayXd q = m.position.col(j).array() - m.position.col(j).mean();
      most = std::max(most, std::sqrt(q.square().mean()) / std::max(noise[j], 1e-300));
    }
  }
  if (most < kLeastMotion) return "the machine never moves beyond its sensor's noise";
  if (windows(data, kWindow).empty()) return "no stretch of a second without a gap";
  return "";
}

std::vector<Measured> read_all(const std::vector<RecordingFile>& files, const Signals& signals) {
  std::vector<Measured> data;
  for (const RecordingFile& file : files) data.push_back(read_recording(file, signals));
  return data;
}

ordered_json times_json(const std::vector<Interval>& times, const std::vector<Measured>& data) {
  ordered_json list = ordered_json::array();
  for (const Interval& interval : times) {
    const Measured& m = data[interval.recording];
    list.push_back({{"recording", m.name},
                    {"from", m.start + interval.from},
                    {"to", m.start + interval.to},
                    {"score", interval.score}});
  }
  return list;
}

/// Measured against the user's own simulations.
ordered_json compare_simulations(const DiagnosisSpec& spec, const std::vector<Measured>& data,
                                 const Eigen::VectorXd& noise) {
  std::vector<Interval> times;
  Eigen::VectorXd worst = Eigen::VectorXd::Zero(noise.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    if (spec.recordings[r].simulation.empty()) continue;
    const Departure found = departure(data[r], read_simulation(spec.recordings[r], spec.signals, data[r]), noise, r);
    times.insert(times.end(), found.times.begin(), found.times.end());
    worst = worst.cwiseMax(found.distance);
  }
  ordered_json mismatch = empty_diagnosis()["mismatch"];
  mismatch["detected"] = !times.empty();
  mismatch["p_value"] = times.empty() ? 1.0 : 0.0;
  mismatch["time"] = times_json(times, data);
  if (Eigen::Index joint = 0; !times.empty()) {
    worst.maxCoeff(&joint);
    mismatch["joint"] = joint + 1;
  }
  return mismatch;
}

}  // namespace

Diagnosis diagnose(const DiagnosisSpec& spec, const StageBegins& begins) {
  const auto stage = [&](int percent, std::string_view text) {
    if (begins) begins(percent, text);
  };
  if (const std::vector<SpecError> missing = missing_files(spec); !missing.empty()) throw missing.front();
  const auto begun = std::chrono::steady_clock::now();
  Diagnosis result;
  ordered_json& json = result.json = empty_diagnosis();
  json["name"] = spec.name;
  json["fit"]["horizon_s"] = spec.horizon;
  const std::string unit = spec.signals.position.front().unit;
  const bool slide = spec.model.plant && std::holds_alternative<Mass>(*spec.model.plant);
  json["fit"]["unit"] = !unit.empty() ? unit : slide ? "m" : "rad";
  const auto finish = [&] {
    json["seconds"] = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  };

  const std::vector<Measured> all_data = read_all(spec.recordings, spec.signals);
  const Eigen::VectorXd first_noise = noise_level(all_data);
  json["fit"]["noise_floor"] = first_noise.norm() / std::sqrt(static_cast<double>(first_noise.size()));
  if (const std::string reason = too_little(all_data, first_noise); !reason.empty()) {
    json["reason"] = reason;
    finish();
    return result;
  }
  const bool simulations = std::any_of(spec.recordings.begin(), spec.recordings.end(),
                                       [](const RecordingFile& file) { return !file.simulation.empty(); });
  if (simulations) {
    const ordered_json mismatch = compare_simulations(spec, all_data, first_noise.cwiseMax(1e-12));
    if (!spec.model.plant) {
      json["mismatch"] = mismatch;
      json["verdict"] = "unknown";
      json["reason"] = "no model: measured and simulated motion are compared, nothing is explained";
      finish();
      return result;
    }
    json["simulation_mismatch"] = mismatch;
  }

  const int joints = spec.joints();
  const Plant& nominal = *spec.model.plant;
  const double fastest = std::max(kFastestMode, kBandwidth * mean_frequency(all_data, first_noise));
  const ExplainOptions options{spec.effects, spec.model.free, kWindow * kFastestMode / fastest, fastest};
  const std::vector<Measured> data = decimated(all_data, kSamplesPerPeriod * fastest);
  stage(2, "searching explanations");
  Explanation explanation = explain(nominal, data, options);
  stage(50, "comparing the best");
  prefer_simple(explanation, data, options, spec.horizon);
  const Fit& best = explanation.best().fit;
  const Fit& empty = explanation.without_effects().fit;
  const Linearisation& about = *explanation.linearisation;
  json["fit"]["noise_floor"] = explanation.noise_rms();

  // The nominal as given.
  const LinearResponse response_as_given(nominal, data, explanation.measured->paths, explanation.noise,
                                         about.response->windows(), options.fastest_mode);
  const FitProblem as_given{
      nominal, nominal, {}, data, response_as_given, *about.excitation, options.penalty, explanation.max_step};
  const Fit given = spec.model.free.empty() ? empty : fit(as_given, {});
  const double p_given = explanation.p_value(given), p_best = explanation.p_value(best);

  // Verdict.
  stage(60, "testing what they leave");
  const bool named_something = !best.effects.empty();
  const bool significant = p_best < (named_something ? kSignificant : kNothing);
  const std::vector<Trajectory> smoothed = smooth_all(nominal, data, explanation.noise);
  const Corrected before{nominal, {}, {}}, refit{empty.plant, {}, {}};
  const Alike alike = find_alike(explanation, joints);
  const Discrepancy discrepancy(*explanation.measured, data);
  const Cleared missing = without_free(*explanation.measured, explanation.start, data, spec.model.free);
  Verdict verdict = named_something ? Verdict::named : Verdict::nothing_missing;
  Fit said_fit = best;  // the model that is stated
  Remainder remainder;
  std::optional<Discrepancy::Dependence> whole;  // what all that is missing depends on,
  Discrepancy::Dependence left;                  // and what the stated model leaves
  double share = 0.0;
  if (significant) {
    share = error_beyond_noise(best, explanation, data, smoothed, spec.horizon) /
            std::max(error_beyond_noise(empty, explanation, data, smoothed, spec.horizon), 1e-300);
    Discrepancy::Beside odds;
    if (named_something) odds = discrepancy.beside(missing.columns, missing.target, options.penalty);
    const bool earned = named_something && odds.log_odds > kEarned;
    if (!earned || share > kMaterial) verdict = Verdict::unknown;
    std::optional<Discrepancy> anew;
    if (explanation.linearisation != explanation.measured) anew.emplace(about, data);
    const Discrepancy& about_best = anew ? *anew : discrepancy;
    const StandIn found =
        verdict == Verdict::unknown
            ? stand_in(explanation, discrepancy, about_best, missing.target, data, smoothed, spec.horizon)
            : beside_best(explanation, about_best, data, smoothed, spec.horizon);
    said_fit = found.fit;
    remainder = found.remainder;
    left = found.remaining;
    if (verdict == Verdict::unknown) whole = found.whole;
  }
  if (verdict == Verdict::named && alike.probability < kConfident) verdict = Verdict::ambiguous;
  const Corrected corrected{said_fit.plant, said_fit.effects, {}};
  const bool say_effects = !corrected.effects.empty();
  const bool parameters_explain = verdict == Verdict::nothing_missing && p_given < kNothing && !spec.model.free.empty();
  const bool detected = verdict != Verdict::nothing_missing || parameters_explain;
  json["verdict"] = to_name(verdict);

  // Where.
  ordered_json& mismatch = json["mismatch"];
  mismatch["detected"] = detected;
  mismatch["p_value"] = p_given;
  mismatch["explained_by_parameters"] = parameters_explain;
  if (detected) {
    mismatch["time"] = times_json(significant_times(explanation, data, smoothed), data);
    if (!whole) whole = discrepancy.dependence(missing.target);
    mismatch["depends_on"] = shares_json(whole->shares());
    mismatch["joint"] = whole->joint + 1;
    mismatch["channel"] = whole->leads() == Cause::input ? "input" : "drift";
    if (say_effects) {
      const Effect& main = best.effects[strongest(explanation)];
      mismatch["channel"] = channel(main.form);
      mismatch["joint"] = main.joint + 1;
    }
  }

  // Which.
  ordered_json& said = json["explanation"];
  if (say_effects) {
    for (std::size_t e = 0; e < best.effects.size(); ++e) said["effects"].push_back(effect_json(best, e, data));
    said["equation"] = equation(best.effects, joints);
    said["probability"] = alike.probability;
    for (const std::vector<std::string>& names : alike.classes) {
      if (names.size() > 1) json["indistinguishable"].push_back(names);
    }
  } else {
    said["probability"] = verdict == Verdict::nothing_missing ? explanation.best().probability : 0.0;
  }
  for (const Candidate& candidate : explanation.candidates) {
    if (&candidate == &explanation.best() || candidate.probability < kShown) continue;
    const bool counted = std::find(alike.sets.begin(), alike.sets.end(), &candidate) != alike.sets.end();
    json["alternatives"].push_back({{"effects", labels(candidate.fit.effects, joints)},
                                    {"probability", candidate.probability},
                                    {"equation", equation(candidate.fit.effects, joints)},
                                    {"indistinguishable", counted && say_effects}});
    if (json["alternatives"].size() >= 10) break;
  }
  if (significant && verdict != Verdict::nothing_missing) {
    json["remainder"] = {{"share", std::min(1.0, share * share)}, {"depends_on", shares_json(left.shares())}};
  }
  for (const std::string& name : parameter_names(nominal)) {
    const std::vector<std::string>& free = spec.model.free;
    const bool estimated = std::find(free.begin(), free.end(), name) != free.end();
    json["parameters"][name] = parameter_json(nominal, said_fit, name, estimated);
  }

  // Fit on the training recordings.
  stage(80, "simulating the recordings");
  Corrected after = corrected;
  if (verdict == Verdict::unknown) after.remainder = remainder;
  if (verdict == Verdict::nothing_missing) after = refit;
  const auto report = [&](const std::vector<Measured>& recordings, const std::vector<Trajectory>& paths, bool held_out,
                          std::string_view set) {
    ordered_json fits = no_fit();
    const FreeRuns runs_before = free_runs(before, recordings, paths, spec.horizon, held_out, explanation.max_step);
    const FreeRuns runs_after = free_runs(after, recordings, paths, spec.horizon, held_out, explanation.max_step);
    fits["before"] = runs_before.rms;
    fits["refit"] = spec.model.free.empty()
                        ? runs_before.rms
                        : free_runs(refit, recordings, paths, spec.horizon, held_out, explanation.max_step).rms;
    fits["after"] = runs_after.rms;
    if (significant && verdict != Verdict::unknown && !remainder.empty()) {
      Corrected more = after;
      more.remainder = remainder;
      fits["after_with_remainder"] =
          free_runs(more, recordings, paths, spec.horizon, held_out, explanation.max_step).rms;
    }
    add_runs(result.fit, set, recordings, runs_before, runs_after);
    return fits;
  };
  json["fit"]["train"] = report(all_data, smooth_all(nominal, all_data, explanation.noise), false, "train");
  stage(88, "planning the next experiment");
  const FitProblem about_best = problem_about(about, explanation, data, options);
  const std::vector<ResidualTests> tests =
      residual_tests(about, data, explanation.noise, {rests(as_given, given), rests(about_best, best)});
  json["residual"] = {{"before", residual_json(tests[0], data)}, {"after", residual_json(tests[1], data)}};
  json["next_experiment"] = propose(nominal, explanation, data, joints);
  if (json["next_experiment"].is_object()) {
    const std::string stated = spec.signals.input.empty() ? "" : spec.signals.input.front().unit;
    const bool known = !std::holds_alternative<Custom>(nominal);
    json["next_experiment"]["signal"]["unit"] = !stated.empty() ? stated : !known ? "" : slide ? "N" : "N m";
  }

  // Hold out: only now.
  if (!spec.held_out.empty()) {
    stage(94, "simulating held-out recordings");
    const std::vector<Measured> test = read_all(spec.held_out, spec.signals);
    json["fit"]["held_out"] = report(test, smooth_all(nominal, test, explanation.noise), true, "held_out");
  }
  result.missing_torque = torque_table(data, smoothed);
  result.model = model_json(spec, after, said_fit);
  finish();
  return result;
}

void write_diagnosis(const Diagnosis& diagnosis, const std::filesystem::path& folder) {
  FileBatch batch;
  batch.add(folder / "diagnosis.json", diagnosis.json.dump(2) + "\n");
  if (!diagnosis.model.is_null()) batch.add(folder / "model.yaml", to_yaml(diagnosis.model));
  if (!diagnosis.missing_torque.columns.empty()) {
    batch.add(folder / "missing_torque.csv", to_csv(diagnosis.missing_torque, 7));
  }
  if (!diagnosis.fit.columns.empty()) batch.add(folder / "fit.csv", to_csv(diagnosis.fit, 7));
  batch.commit();
}

}  // namespace bayesctrl
