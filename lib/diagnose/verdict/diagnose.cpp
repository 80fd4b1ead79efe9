#include "diagnose/verdict/diagnose.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/format.hpp"
#include "diagnose/motion/decimate.hpp"
#include "diagnose/recording/read_recording.hpp"
#include "diagnose/settings.hpp"
#include "diagnose/verdict/alone.hpp"
#include "diagnose/verdict/compared.hpp"
#include "diagnose/verdict/doubts.hpp"
#include "diagnose/verdict/in_time.hpp"
#include "diagnose/verdict/inclusion.hpp"
#include "diagnose/verdict/judge.hpp"
#include "diagnose/verdict/present.hpp"
#include "diagnose/verdict/propose.hpp"
#include "diagnose/verdict/searchable.hpp"
#include "diagnose/verdict/sentence.hpp"
#include "diagnose/verdict/uncertainty.hpp"
#include "diagnose/verdict/units.hpp"
#include "diagnose/verdict/where.hpp"
#include "diagnose/verdict/which.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "io/provenance.hpp"
#include "physics/catalogue.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

std::vector<Measured> read_all(const std::vector<RecordingFile>& files, const Signals& signals) {
  std::vector<Measured> data;
  for (const RecordingFile& file : files) data.push_back(read_recording(file, signals));
  return data;
}

/// A copy of a recording tells nothing new, and would make everything look more certain than it is.
void require_different(const DiagnosisSpec& spec, const std::vector<Measured>& data) {
  for (std::size_t i = 0; i < data.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) {
      if (data[i].time != data[k].time || data[i].position != data[k].position || data[i].input != data[k].input)
        continue;
      throw SpecError(spec.recordings[i].where, "'" + spec.recordings[i].name + "' holds the samples of '" +
                                                    spec.recordings[k].name + "': leave one of them out");
    }
  }
}

/// Measured against the user's own simulations.
Mismatch compare_simulations(const DiagnosisSpec& spec, const std::vector<Measured>& data,
                             const Eigen::VectorXd& noise) {
  std::vector<Interval> times;
  Eigen::VectorXd worst = Eigen::VectorXd::Zero(noise.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    if (spec.recordings[r].simulation.empty()) continue;
    const Departure found = departure(data[r], read_simulation(spec.recordings[r], spec.signals, data[r]), noise, r);
    times.insert(times.end(), found.times.begin(), found.times.end());
    worst = worst.cwiseMax(found.distance);
  }
  Mismatch mismatch;
  mismatch.detected = !times.empty();
  mismatch.p_value = times.empty() ? 1.0 : 0.0;
  mismatch.time = shown(times, data);
  if (Eigen::Index joint = 0; !times.empty()) {
    worst.maxCoeff(&joint);
    mismatch.joint = static_cast<int>(joint) + 1;
  }
  return mismatch;
}

/// What is said before anything was searched.
Diagnosis blank(const DiagnosisSpec& spec) {
  Diagnosis blank;
  blank.name = spec.name;
  blank.joints = spec.joints();
  blank.units = joint_units(spec);
  blank.fit.unit = blank.units.front().position;
  blank.fit.horizon = spec.horizon;
  return blank;
}

/// Weighs what a search has found as models none of which need be right, and without what does not matter.
void settle(Explanation& explanation, const std::vector<Measured>& data, const ExplainOptions& options,
            double horizon) {
  prefer_simple(explanation, data, options, horizon);
  merge_immaterial(explanation);
}

/// Explains what was thinned out or, where that is too coarse, the `recordings` as they are, which are `data` then.
Search search(const DiagnosisSpec& spec, const std::vector<Measured>& recordings, std::vector<Measured>& data,
              const ExplainOptions& options, const StageBegins& stage) {
  const Plant& nominal = *spec.model.plant;
  stage(2, "searching explanations");
  std::vector<Measured> whole = searched_as_recorded(recordings);
  ExplainOptions first = options;
  if (samples(data) < samples(whole)) first.whole = &whole;
  Explanation explanation = explain(nominal, data, first);
  if (explanation.too_coarse) {
    data = std::move(whole);
    ExplainOptions second = options;
    second.known = best_sets(explanation);
    explanation = explain(nominal, data, second);
  }
  stage(50, "comparing the best");
  settle(explanation, data, options, spec.horizon);
  std::vector<Trajectory> smoothed = smooth_all(nominal, data, explanation.noise);
  return {spec, nominal, data, options, std::move(explanation), std::move(smoothed)};
}

/// What the nominal leaves as it was given.
struct AsGiven {
  double p_value = 1.0;
  std::vector<Eigen::MatrixXd> residuals;
};

AsGiven nominal_as_given(const Search& search) {
  const Explanation& explanation = search.explanation;
  const LinearResponse response(search.nominal, search.data, explanation.measured->paths, explanation.noise,
                                search.about().response->windows(), search.options.fastest_mode);
  const FitProblem problem{search.nominal,      search.nominal,      {}, search.data, response, *search.about().forcing,
                           explanation.penalty, explanation.max_step};
  const Fit given = search.options.free.empty() ? search.refit() : fit(problem, {});
  return {explanation.p_value(given), residuals(problem, given)};
}

/// Where the mismatch is: when, on what it depends, in which joint and on which side of the machine.
Mismatch locate(const Search& search, const Judgement& judgement) {
  Mismatch mismatch;
  mismatch.detected = judgement.detected();
  mismatch.p_value = judgement.p_given;
  mismatch.explained_by_parameters = judgement.parameters_explain;
  if (!mismatch.detected) return mismatch;
  mismatch.time = shown(significant_times(search.explanation, search.data, search.smoothed), search.data);
  mismatch.depends_on = shown(judgement.whole->shares());
  mismatch.joint = judgement.whole->joint + 1;
  mismatch.channel = judgement.whole->leads() == Cause::input ? Channel::input : Channel::drift;
  if (judgement.says_effects()) {
    const Effect& main = search.best().effects[strongest(search.explanation)];
    mismatch.channel = channel_of(main.form);
    mismatch.joint = main.joint + 1;
  }
  return mismatch;
}

Explained explained(const Search& search, const Judgement& judgement, const std::vector<JointUnits>& units) {
  Explained result;
  if (!judgement.says_effects()) {
    const bool nothing = judgement.verdict == Verdict::nothing_missing;
    result.probability = nothing ? search.explanation.best().probability : 0.0;
    return result;
  }
  const Fit& best = search.best();
  const std::vector<double> share = shares(search.explanation, search.data, search.options, search.spec.horizon);
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    result.effects.push_back(shown_effect(best, e, search.data, units));
    result.effects.back().inclusion = judgement.equivalence.inclusion[e];
    result.effects.back().share = share[e];
  }
  result.equation = equation(best.effects, search.spec.joints());
  result.probability = judgement.equivalence.probability;
  return result;
}

std::vector<Alternative> alternatives(const Search& search, const Judgement& judgement) {
  const int joints = search.spec.joints();
  const std::vector<const Candidate*>& equivalent = judgement.equivalence.sets;
  std::vector<Alternative> list;
  for (const Candidate& candidate : search.explanation.candidates) {
    if (&candidate == &search.explanation.best() || candidate.probability < kSettings.verdict.shown_alternative)
      continue;
    const bool counted = std::find(equivalent.begin(), equivalent.end(), &candidate) != equivalent.end();
    list.push_back({labels(candidate.fit.effects, joints), candidate.probability,
                    equation(candidate.fit.effects, joints), counted && judgement.says_effects()});
    if (list.size() >= std::size_t{kSettings.verdict.most_alternatives}) break;
  }
  return list;
}

/// States what was found: which physics, what else it may be, what is left, and the nominal's parameters.
void state(Diagnosis& diagnosis, const Search& search, const Judgement& judgement) {
  diagnosis.verdict = judgement.verdict;
  diagnosis.fit.noise_floor = search.explanation.noise_rms();
  diagnosis.mismatch = locate(search, judgement);
  diagnosis.explanation = explained(search, judgement, diagnosis.units);
  if (diagnosis.verdict != Verdict::check_spec) {
    for (const auto& [name, p] : inclusion(search.explanation)) {
      if (p >= kSettings.verdict.listed) diagnosis.inclusion.items.emplace_back(name, p);
    }
  }
  for (const std::vector<std::string>& names : judgement.equivalence.classes) {
    if (judgement.says_effects() && names.size() > 1) diagnosis.indistinguishable.push_back(names);
  }
  diagnosis.alternatives = alternatives(search, judgement);
  if (judgement.significant && judgement.verdict != Verdict::nothing_missing) {
    diagnosis.remainder = {std::min(1.0, judgement.share * judgement.share), shown(judgement.left.shares())};
  }
  const std::vector<std::string>& free = search.options.free;
  for (const std::string& name : parameter_names(search.nominal)) {
    const bool estimated = std::find(free.begin(), free.end(), name) != free.end();
    diagnosis.parameters.items.emplace_back(
        name, shown_parameter(search.nominal, judgement.fit, name, estimated, diagnosis.units.front()));
  }
}

Residual test_residuals(const Search& search, const AsGiven& given) {
  const FitProblem about_best = problem_about(search.about(), search.explanation, search.data, search.options);
  const std::vector<ResidualTests> tests = residual_tests(search.about(), search.data, search.explanation.noise,
                                                          {given.residuals, residuals(about_best, search.best())});
  return {shown(tests[0], search.data), shown(tests[1], search.data)};
}

/// Whether there is something to explain, and a model to explain it with: else the reason is stated.
bool can_be_explained(const DiagnosisSpec& spec, const std::vector<Measured>& recordings, const Eigen::VectorXd& noise,
                      Diagnosis& diagnosis) {
  diagnosis.fit.noise_floor = rms(noise);
  diagnosis.reason = too_little(recordings, noise);
  if (!diagnosis.reason.empty()) return false;
  const bool simulations = std::any_of(spec.recordings.begin(), spec.recordings.end(),
                                       [](const RecordingFile& file) { return !file.simulation.empty(); });
  if (!simulations) return true;
  Mismatch mismatch = compare_simulations(spec, recordings, noise.cwiseMax(1e-12));
  if (spec.model.plant) {
    diagnosis.simulation_mismatch = std::move(mismatch);
    return true;
  }
  diagnosis.mismatch = std::move(mismatch);
  diagnosis.verdict = Verdict::unknown;
  diagnosis.reason = "no model: measured and simulated motion are compared, nothing is explained";
  return false;
}

void require_horizon(const DiagnosisSpec& spec, const std::vector<Measured>& data) {
  if (const std::string why = no_window(data, spec.horizon); !data.empty() && !why.empty()) {
    throw SpecError(spec.horizon_at, "horizon_s = " + why);
  }
}

/// What a model adds to the nominal along the motion: samples x joints, of each recording.
std::vector<Eigen::MatrixXd> explained_torque(const Search& search, const Fit& fit) {
  const Forcing forcing(search.nominal, search.data, search.smoothed);
  std::vector<Eigen::MatrixXd> list;
  for (std::size_t r = 0; r < search.data.size(); ++r) list.push_back(forcing.torque(fit.plant, fit.effects, r));
  return list;
}

/// Whether physics alone is an answer that leaves no doubt of the spec.
bool beyond_doubt(const Search& search, const Judgement& judgement) {
  if (judgement.verdict == Verdict::nothing_missing) return true;
  const std::vector<Effect>& effects = search.best().effects;
  const auto is_part = [&](std::size_t kind) {
    return std::ranges::any_of(effects, [&](const Effect& effect) { return effect.form.index() == kind; });
  };
  if (effects.size() > 1 && std::ranges::any_of(resizing_kinds(), is_part)) return false;
  const bool left = judgement.significant && judgement.share > kSettings.verdict.material;
  return !left && judgement.verdict != Verdict::unknown && !implausible(search.best(), search.data);
}

/// Physics is not what is stated.
void doubted(Judgement& judgement, const Search& search) {
  judgement.verdict = Verdict::check_spec;
  judgement.fit = search.refit();
  judgement.remainder = {};
  judgement.equivalence = {};
}

/// Sets that switch the input off are no physics: while the motion answers to the input, the others say what is
/// missing. Numbers that are settled anew may switch it off again.
void drop_dead_inputs(Search& search) {
  while (switches_input_off(search.best(), search.data)) {
    std::erase_if(search.explanation.candidates,
                  [&](const Candidate& c) { return switches_input_off(c.fit, search.data); });
    settle(search.explanation, search.data, search.options, search.spec.horizon);
  }
}

/// Explains recordings by a search on thinned-out ones. Held-out recordings are looked at last.
void explain_all(const DiagnosisSpec& spec, const std::vector<Measured>& recordings,
                 const std::vector<Measured>& held_out, const Eigen::VectorXd& noise, const StageBegins& stage,
                 Diagnosed& result) {
  Diagnosis& diagnosis = result.diagnosis;
  const ExplainOptions options = search_options(spec, recordings, noise);
  std::vector<Measured> data = thinned(*spec.model.plant, recordings, options, noise);
  const auto compared = [](const std::vector<Measured>& all) {
    return excerpts(all, kSettings.recording.compared, kSettings.recording.excerpt);
  };
  Doubts doubts(spec, recordings);
  const bool gross = doubts.gross();
  if (gross) stage(2, "doubting the spec");
  const double as_given = gross ? as_given_error(spec, data, noise) : kInfinity;
  if (gross && doubts.decide(as_given, std::nullopt, diagnosis, true) && !beside_asked(diagnosis.suspicions)) {
    diagnosis.mismatch.detected = true;
    return;
  }
  std::optional<Search> searched;
  try {
    searched.emplace(search(spec, recordings, data, options, stage));
  } catch (const NumericalError&) {  // no physics makes this nominal run: any mistake that does is an answer
    doubts.decide(as_given, std::nullopt, diagnosis);
    if (diagnosis.suspicions.empty()) throw;
    diagnosis.verdict = Verdict::check_spec;
    diagnosis.mismatch.detected = true;
    return;
  }
  Search& found = *searched;
  stage(60, "testing what they leave");
  const AsGiven given = nominal_as_given(found);
  const Missing missing = missing_torque(found);
  Judgement judgement = judge(found, missing, given.p_value);
  if (gross || !beyond_doubt(found, judgement)) {
    stage(70, "doubting the spec");
    const Models models = models_of(found, judgement);
    const auto error = [&](const Corrected& model) {
      return free_runs(model, data, found.smoothed, spec.horizon, false, found.explanation.max_step).rms;
    };
    if (doubts.decide(error(models.before), Looked{found.explanation, error(models.after), motion_rms(data)},
                      diagnosis)) {
      doubted(judgement, found);
    } else if (switches_input_off(found.best(), data)) {
      drop_dead_inputs(found);
      judgement = judge(found, missing, given.p_value);
    }
  }
  drop_refuted_remainder(judgement, found, compared(held_out));
  state(diagnosis, found, judgement);

  stage(80, "simulating the recordings");
  const Models models = models_of(found, judgement);
  diagnosis.fit.recorded = recorded_seconds(recordings);
  diagnosis.fit.searched = recorded_seconds(data);
  for (const Measured& m : recordings) {
    if (m.left_out > 0) diagnosis.fit.left_out = diagnosis.fit.left_out.value_or(0.0) + static_cast<double>(m.left_out);
  }
  const Compared train = compare(models, found, compared(recordings), false, diagnosis.units, result.runs);
  diagnosis.fit.train = train.errors;
  Eigen::VectorXd left = train.left(found.explanation.noise);
  stage(88, "planning the next experiment");
  diagnosis.residual = test_residuals(found, given);
  diagnosis.next_experiment = propose(found.nominal, found.explanation, data, diagnosis.units);
  if (!held_out.empty()) {
    stage(94, "simulating held-out recordings");
    const Compared other = compare(models, found, compared(held_out), true, diagnosis.units, result.runs);
    diagnosis.fit.held_out = other.errors;
    left = left.cwiseMax(other.left(found.explanation.noise));
  }
  hold_to_account(diagnosis, motion_rms(data), held_out.empty() ? 0.0 : rms(noise_level(held_out)));
  doubt_beside_remainder(diagnosis);
  doubt_beside_discrepancy(diagnosis, judgement.beside);
  const Explanation& explanation = found.explanation;
  std::vector<Effect> unconfirmed;
  for (const std::size_t e :
       unconfirmed_in_time(models.after, {compared(recordings), compared(held_out), found.nominal, explanation.noise,
                                          spec.horizon, explanation.max_step})) {
    unconfirmed.push_back(models.after.effects[e]);
  }
  doubt_in_time(diagnosis, unconfirmed);
  const bool open = diagnosis.verdict == Verdict::unknown || diagnosis.verdict == Verdict::ambiguous;
  if (open && !has_certain(diagnosis)) diagnosis.alone = each_alone(found, missing.rows());
  result.missing_torque = torque_table(data, found.smoothed, explained_torque(found, judgement.fit), diagnosis.units);
  result.model = model_json(spec, models.after, judgement.fit,
                            uncertainty_of(models.after, judgement.fit, found.nominal, data, found.smoothed, left));
}

}  // namespace

Diagnosed diagnose(const DiagnosisSpec& spec, const StageBegins& begins) {
  const auto begun = std::chrono::steady_clock::now();
  Diagnosed result{blank(spec), {}, {}, {}};
  const std::vector<Measured> recordings = read_all(spec.recordings, spec.signals);
  require_different(spec, recordings);
  const Eigen::VectorXd noise = noise_level(recordings);
  const StageBegins stage = begins ? begins : [](int, std::string_view) {};
  if (can_be_explained(spec, recordings, noise, result.diagnosis)) {
    const std::vector<Measured> held_out = read_all(spec.held_out, spec.signals);  // what is wrong there is said now
    require_horizon(spec, recordings);
    require_horizon(spec, held_out);
    explain_all(spec, recordings, held_out, noise, stage, result);
  } else if (spec.model.plant) {  // in another unit of time there may be enough
    Doubts(spec, recordings).decide(kInfinity, std::nullopt, result.diagnosis);
  }
  result.diagnosis.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begun).count();
  return result;
}

void write_diagnosis(const Diagnosed& diagnosed, const std::filesystem::path& folder) {
  FileBatch batch;
  batch.add(folder / "diagnosis.json", to_json(diagnosed.diagnosis).dump(2) + "\n");
  if (!diagnosed.model.is_null()) batch.add(folder / "model.yaml", to_yaml(diagnosed.model));
  if (!diagnosed.missing_torque.columns.empty()) {
    batch.add(folder / "missing_torque.csv", to_csv(diagnosed.missing_torque, 7));
  }
  if (!diagnosed.runs.columns.empty()) batch.add(folder / "fit.csv", to_csv(diagnosed.runs, 7));
  batch.commit();
}

void write_origin(const DiagnosisSpec& spec, const std::filesystem::path& file, const std::filesystem::path& folder) {
  nlohmann::ordered_json origin = provenance(file.filename().string(), to_json(spec));
  origin["settings"] = to_json(kSettings);
  write_file(folder / "provenance.json", origin.dump(2) + "\n");
}

}  // namespace bayesctrl
