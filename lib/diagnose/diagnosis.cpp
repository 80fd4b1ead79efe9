#include "diagnose/diagnosis.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/format.hpp"
#include "diagnose/discrepancy.hpp"
#include "diagnose/explain.hpp"
#include "diagnose/free_runs.hpp"
#include "diagnose/propose.hpp"
#include "diagnose/read_recording.hpp"
#include "io/emit.hpp"
#include "io/files.hpp"
#include "spec/model.hpp"

namespace bayesctrl {

namespace {

using nlohmann::ordered_json;

constexpr double kSignificant = 1e-4;       // p-value of what the best explanation leaves
constexpr double kNothing = 1e-5;           // p-value of the nominal alone, where no effect explains anything
constexpr double kFarFromNoise = 3.0;       // noise, RMS, left by the best explanation
constexpr double kWindow = 2.0;             // s, over which explanations are fitted
constexpr double kFastestMode = 10.0;       // Hz, of the mechanics, at least
constexpr double kBandwidth = 2.5;          // times the motion's mean frequency
constexpr double kSamplesPerPeriod = 20.0;  // of the fastest mode; more are thinned out for the search
constexpr double kMaterial = 0.1;           // of the refit nominal's error
constexpr double kEarned = 0.0;             // nats by which effects beside a remainder must beat it alone
constexpr double kConfident = 0.9;          // probability, below which the verdict is `ambiguous`
constexpr double kInseparable = 3.0;        // nats
constexpr double kShown = 1e-4;             // probability of an alternative that is listed
constexpr double kLeastDuration = 1.0;      // s of recording
constexpr double kLeastSamples = 60.0;
constexpr double kLeastMotion = 5.0;      // of the noise, RMS: below, the machine never moved
constexpr double kSignificantBand = 3.0;  // standard deviations of the missing torque

enum class Verdict { named, nothing_missing, ambiguous, unknown, too_little_data };
constexpr std::array<std::string_view, 5> names(Verdict) {
  return {"named", "nothing_missing", "ambiguous", "unknown", "too_little_data"};
}

ordered_json shares_json(const Shares& shares) {
  ordered_json object;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    object[std::string(names(Cause{})[i])] = std::round(shares[i] * 1e6) / 1e6;
  }
  return object;
}

ordered_json no_fit() { return {{"before", nullptr}, {"refit", nullptr}, {"after", nullptr}}; }

/// Every key of the contract, empty.
ordered_json skeleton() {
  return {
      {"name", ""},
      {"verdict", "too_little_data"},
      {"reason", ""},
      {"mismatch",
       {{"detected", false},
        {"p_value", 1.0},
        {"explained_by_parameters", false},
        {"time", ordered_json::array()},
        {"depends_on", shares_json({})},
        {"channel", nullptr},
        {"joint", nullptr}}},
      {"explanation", {{"effects", ordered_json::array()}, {"equation", ""}, {"probability", 0.0}}},
      {"remainder", nullptr},
      {"alternatives", ordered_json::array()},
      {"indistinguishable", ordered_json::array()},
      {"fit", {{"unit", "rad"}, {"horizon_s", 1.0}, {"noise_floor", 0.0}, {"train", no_fit()}, {"held_out", no_fit()}}},
      {"next_experiment", nullptr},
      {"parameters", ordered_json::object()},
      {"seconds", 0.0}};
}

/// "torque -= 0.31 sign(v)" from the effect's equation.
std::string equation(const Effect& effect, int joints) {
  std::string text = std::visit([](const auto& form) { return std::string(form.kEquation); }, effect.form);
  for (std::size_t open = text.find('{'); open != std::string::npos; open = text.find('{')) {
    const std::size_t close = text.find('}', open);
    const double value = parameter(effect.form, text.substr(open + 1, close - open - 1));
    text.replace(open, close - open + 1, format(value, 4));
  }
  return joints == 1 ? text : "joint " + std::to_string(effect.joint + 1) + ": " + text;
}

std::string sentence(const Effect& effect) {
  return std::visit([](const auto& form) { return std::string(form.kText); }, effect.form);
}

std::vector<std::string> labels(const std::vector<Effect>& effects, int joints) {
  std::vector<std::string> list;
  for (const Effect& effect : effects) list.push_back(label(effect, joints));
  return list;
}

ordered_json effect_json(const Fit& fit, std::size_t e, const std::vector<Measured>& data) {
  const Effect& effect = fit.effects[e];
  ordered_json parameters = ordered_json::object();
  std::visit(
      [&]<class E>(const E& form) {
        E::fields(form, [&](std::string_view name, double value, const Info& info) {
          double sd = 0.0;
          for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
            if (fit.unknowns[i].effect == static_cast<int>(e) && fit.unknowns[i].name == name) {
              sd = std::sqrt(std::max(0.0, fit.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))));
            }
          }
          parameters[std::string(name)] = {{"value", value}, {"sd", sd}, {"unit", info.unit}};
        });
      },
      effect.form);
  ordered_json object{{"name", name_of(effect.form)}, {"joint", effect.joint + 1}, {"parameters", parameters}};
  if (effect.recording >= 0) object["recording"] = data[static_cast<std::size_t>(effect.recording)].name;
  object["text"] = sentence(effect);
  return object;
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
  if (windows(data, 2.0).empty() || windows(data, 2.0).size() < 1) return "no stretch of a second without a gap";
  return "";
}

struct Interval {
  std::size_t recording = 0;
  double from = 0.0, to = 0.0, score = 0.0;
};

/// Where the band of the missing torque excludes zero; where none does, windows that the nominal alone does not fit.
std::vector<Interval> significant_times(const Explanation& explanation, const std::vector<Measured>& data,
                                        const std::vector<Trajectory>& smoothed) {
  std::vector<Interval> list;
  for (const Effect& effect : explanation.best().fit.effects) {
    if (const auto* step = std::get_if<TorqueStep>(&effect.form)) {
      const auto r = static_cast<std::size_t>(std::max(0, effect.recording));
      const auto i = static_cast<std::size_t>(&effect - explanation.best().fit.effects.data());
      double score = 0.0;
      for (std::size_t u = 0; u < explanation.best().fit.unknowns.size(); ++u) {
        const Unknown& unknown = explanation.best().fit.unknowns[u];
        if (unknown.effect == static_cast<int>(i) && unknown.name == "torque") {
          const auto at = static_cast<Eigen::Index>(u);
          score = std::abs(unknown.value) / std::sqrt(explanation.best().fit.covariance(at, at));
        }
      }
      list.push_back({r, step->time, data[r].time.back(), score});
    }
  }
  if (!list.empty() && explanation.best().fit.effects.size() == 1) return list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const std::vector<double>& t = data[r].time;
    const double merge = 0.3;
    Interval open{r, -1.0, -1.0, 0.0};
    double squares = 0.0, count = 0.0;
    const auto close = [&] {
      if (open.from >= 0.0 && open.to - open.from > 0.05) {
        open.score = std::sqrt(squares / std::max(1.0, count));
        list.push_back(open);
      }
      open.from = -1.0;
      squares = count = 0.0;
    };
    for (std::size_t k = 0; k < t.size(); ++k) {
      double z = 0.0;
      for (Eigen::Index j = 0; j < smoothed[r].missing_torque.cols(); ++j) {
        const auto row = static_cast<Eigen::Index>(k);
        z = std::max(z, std::abs(smoothed[r].missing_torque(row, j)) / std::max(smoothed[r].torque_sd(row, j), 1e-300));
      }
      if (z > kSignificantBand) {
        if (open.from < 0.0) open.from = t[k];
        open.to = t[k];
        squares += z * z;
        count += 1.0;
      } else if (open.from >= 0.0 && t[k] - open.to > merge) {
        close();
      }
    }
    close();
  }
  if (!list.empty()) return list;
  const Fit& fit = explanation.without_effects().fit;
  const LinearResponse& response = *explanation.linearisation->response;
  for (std::size_t w = 0; w < response.windows().size(); ++w) {
    const Eigen::Index first = response.first_row(w);
    const Eigen::Index last = w + 1 < response.windows().size() ? response.first_row(w + 1) : response.rows();
    const double rows = static_cast<double>(last - first);
    const double z = (fit.residual.segment(first, last - first).squaredNorm() - rows) / std::sqrt(2.0 * rows);
    if (z < kSignificantBand) continue;
    const Segment& window = response.windows()[w];
    const std::vector<double>& t = data[window.recording].time;
    if (!list.empty() && list.back().recording == window.recording && t[window.first] - list.back().to < 0.1) {
      list.back().to = t[window.last];
      list.back().score = std::max(list.back().score, z);
    } else {
      list.push_back({window.recording, t[window.first], t[window.last], z});
    }
  }
  return list;
}

/// Classes of effects that replace each other in the best explanation with hardly any loss.
struct Alike {
  std::vector<std::vector<std::string>> classes;  // one per effect of the best set, the effect itself first
  double probability = 0.0;                       // of all sets made of them
};

Alike find_alike(const Explanation& explanation, int joints) {
  Alike result;
  const Fit& best = explanation.best().fit;
  for (const Effect& effect : best.effects) result.classes.push_back({label(effect, joints)});
  std::vector<std::string> own = labels(best.effects, joints);
  for (const Candidate& candidate : explanation.candidates) {
    const Fit& fit = candidate.fit;
    if (fit.effects.size() != best.effects.size() || best.log_evidence - fit.log_evidence > kInseparable) continue;
    std::vector<std::string> other = labels(fit.effects, joints), lost, won;
    for (const std::string& name : own) {
      const auto at = std::find(other.begin(), other.end(), name);
      if (at == other.end()) {
        lost.push_back(name);
      } else {
        other.erase(at);
      }
    }
    if (lost.size() != 1 || other.size() != 1) continue;
    for (std::vector<std::string>& names : result.classes) {
      if (names.front() == lost.front() && std::find(names.begin(), names.end(), other.front()) == names.end()) {
        names.push_back(other.front());
      }
    }
  }
  for (const Candidate& candidate : explanation.candidates) {
    if (candidate.fit.effects.size() != best.effects.size()) continue;
    std::vector<std::string> left = labels(candidate.fit.effects, joints);
    bool inside = true;
    for (const std::vector<std::string>& names : result.classes) {
      const auto at = std::find_if(left.begin(), left.end(), [&](const std::string& name) {
        return std::find(names.begin(), names.end(), name) != names.end();
      });
      if (at == left.end()) {
        inside = false;
        break;
      }
      left.erase(at);
    }
    if (inside) result.probability += candidate.probability;
  }
  return result;
}

/// The effect without which the explanation loses most.
std::size_t strongest(const Explanation& explanation) {
  const Fit& best = explanation.best().fit;
  std::size_t strongest = 0;
  double most = -kInfinity;
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    std::vector<Effect> fewer = best.effects;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(e));
    const std::string name = key(fewer);
    for (const Candidate& candidate : explanation.candidates) {
      if (key(candidate.fit.effects) != name) continue;
      if (const double loss = best.log_evidence - candidate.fit.log_evidence; loss > most) {
        most = loss;
        strongest = e;
      }
    }
  }
  return strongest;
}

ordered_json signal_json(const Signal& signal) {
  ordered_json object{{"column", signal.column}, {"scale", signal.scale}, {"offset", signal.offset}};
  if (!signal.unit.empty()) object["unit"] = signal.unit;
  if (signal.linear_hold) object["hold"] = "linear";
  return object;
}

ordered_json signals_json(const Signals& signals) {
  ordered_json object;
  object["time"] = signals.time ? signal_json(*signals.time) : ordered_json{{"rate", signals.rate}};
  const auto list = [](const std::vector<Signal>& all) {
    ordered_json array = ordered_json::array();
    for (const Signal& signal : all) array.push_back(signal_json(signal));
    return array;
  };
  object["position"] = list(signals.position);
  object["input"] = list(signals.input);
  return object;
}

ordered_json model_json(const DiagnosisSpec& spec, const Corrected& model, const Fit& fit) {
  ordered_json object{{"name", spec.name}};
  ordered_json plant = json_value(Model{model.plant});
  ordered_json effects = ordered_json::array();
  for (std::size_t e = 0; e < model.effects.size(); ++e) {
    ordered_json effect{{"type", name_of(model.effects[e].form)}, {"joint", model.effects[e].joint + 1}};
    ordered_json deviations = ordered_json::object();
    std::visit(
        [&]<class E>(const E& form) {
          E::fields(form, [&](std::string_view name, double value, const Info&) {
            effect[std::string(name)] = value;
            for (std::size_t i = 0; i < fit.unknowns.size(); ++i) {
              const auto at = static_cast<Eigen::Index>(i);
              if (fit.unknowns[i].effect == static_cast<int>(e) && fit.unknowns[i].name == name) {
                deviations[std::string(name)] = std::sqrt(std::max(0.0, fit.covariance(at, at)));
              }
            }
          });
        },
        model.effects[e].form);
    effect["sd"] = deviations;
    effects.push_back(std::move(effect));
  }
  plant["effects"] = effects;
  if (!model.remainder.empty()) plant["remainder"] = json_value(Model{model.plant, {}, model.remainder})["remainder"];
  object["model"] = plant;
  object["signals"] = signals_json(spec.signals);
  object["horizon_s"] = spec.horizon;
  return object;
}

std::string numbered(const std::string& name, Eigen::Index joint, Eigen::Index joints) {
  return joints == 1 ? name : name + std::to_string(joint + 1);
}

Table torque_table(const std::vector<Measured>& data, const std::vector<Trajectory>& smoothed) {
  const Eigen::Index joints = data.front().position.cols();
  std::vector<Cell> recording;
  std::vector<double> time;
  std::vector<std::vector<double>> mean(static_cast<std::size_t>(joints)), sd(mean.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (std::size_t k = 0; k < data[r].samples(); ++k) {
      recording.emplace_back(data[r].name);
      time.push_back(data[r].start + data[r].time[k]);
      for (Eigen::Index j = 0; j < joints; ++j) {
        mean[static_cast<std::size_t>(j)].push_back(smoothed[r].missing_torque(static_cast<Eigen::Index>(k), j));
        sd[static_cast<std::size_t>(j)].push_back(smoothed[r].torque_sd(static_cast<Eigen::Index>(k), j));
      }
    }
  }
  Table table;
  table.columns.push_back({"recording", "", std::move(recording)});
  table.columns.push_back({"t", "s", std::move(time)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    table.columns.push_back({numbered("torque", j, joints), "N m", std::move(mean[static_cast<std::size_t>(j)])});
    table.columns.push_back({numbered("sd", j, joints), "N m", std::move(sd[static_cast<std::size_t>(j)])});
  }
  return table;
}

/// Adds recordings to fit.csv.
void add_runs(Table& table, std::string_view set, const std::vector<Measured>& data, const FreeRuns& before,
              const FreeRuns& after) {
  const Eigen::Index joints = data.front().position.cols();
  std::vector<Cell> recording, part;
  std::vector<double> time;
  std::vector<std::vector<double>> measured(static_cast<std::size_t>(joints)), nominal(measured.size()),
      corrected(measured.size());
  for (std::size_t r = 0; r < data.size(); ++r) {
    for (std::size_t k = 0; k < data[r].samples(); ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      recording.emplace_back(data[r].name);
      part.emplace_back(std::string(set));
      time.push_back(data[r].start + data[r].time[k]);
      for (Eigen::Index j = 0; j < joints; ++j) {
        const auto slot = static_cast<std::size_t>(j);
        measured[slot].push_back(data[r].position(row, j));
        nominal[slot].push_back(before.simulated[r](row, j));
        corrected[slot].push_back(after.simulated[r](row, j));
      }
    }
  }
  Table more;
  more.columns.push_back({"set", "", std::move(part)});
  more.columns.push_back({"recording", "", std::move(recording)});
  more.columns.push_back({"t", "s", std::move(time)});
  for (Eigen::Index j = 0; j < joints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    more.columns.push_back({numbered("measured", j, joints), "", std::move(measured[slot])});
    more.columns.push_back({numbered("before", j, joints), "", std::move(nominal[slot])});
    more.columns.push_back({numbered("after", j, joints), "", std::move(corrected[slot])});
  }
  if (table.columns.empty()) {
    table = std::move(more);
  } else {
    append(table, more);
  }
}

std::vector<Measured> read_all(const std::vector<RecordingFile>& files, const Signals& signals) {
  std::vector<Measured> data;
  for (const RecordingFile& file : files) data.push_back(read_recording(file, signals));
  return data;
}

std::vector<Trajectory> smooth_all(const Plant& plant, const std::vector<Measured>& data,
                                   const Eigen::VectorXd& noise) {
  const std::vector<TorquePrior> prior = likely_torque_prior(plant, data, noise);
  std::vector<Trajectory> paths;
  for (const Measured& m : data) paths.push_back(smooth(plant, m, noise, prior));
  return paths;
}

/// Without a model: measured against the user's own simulation.
ordered_json compare_simulations(const DiagnosisSpec& spec, const std::vector<Measured>& data,
                                 const Eigen::VectorXd& noise) {
  ordered_json mismatch = skeleton()["mismatch"];
  double worst = 0.0;
  std::size_t worst_joint = 0;
  for (std::size_t r = 0; r < data.size(); ++r) {
    if (spec.recordings[r].simulation.empty()) continue;
    const Eigen::MatrixXd simulated = read_simulation(spec.recordings[r], spec.signals, data[r]);
    const Eigen::MatrixXd z = (data[r].position - simulated) * noise.cwiseInverse().asDiagonal();
    const std::vector<double>& t = data[r].time;
    double from = -1.0, to = 0.0, squares = 0.0, count = 0.0;
    for (std::size_t k = 0; k <= t.size(); ++k) {
      const double largest = k < t.size() ? z.row(static_cast<Eigen::Index>(k)).cwiseAbs().maxCoeff() : 0.0;
      if (k < t.size() && largest > 5.0) {
        if (from < 0.0) from = t[k];
        to = t[k];
        squares += largest * largest;
        count += 1.0;
      } else if (from >= 0.0 && (k == t.size() || t[k] - to > 0.1)) {
        mismatch["time"].push_back({{"recording", data[r].name},
                                    {"from", data[r].start + from},
                                    {"to", data[r].start + to},
                                    {"score", std::sqrt(squares / count)}});
        from = -1.0;
        squares = count = 0.0;
      }
    }
    for (Eigen::Index j = 0; j < z.cols(); ++j) {
      if (const double rms = z.col(j).norm(); rms > worst) {
        worst = rms;
        worst_joint = static_cast<std::size_t>(j);
      }
    }
  }
  mismatch["detected"] = !mismatch["time"].empty();
  mismatch["p_value"] = mismatch["time"].empty() ? 1.0 : 0.0;
  if (!mismatch["time"].empty()) mismatch["joint"] = worst_joint + 1;
  return mismatch;
}

/// Where the best explanation leaves more than noise, likelihoods between imperfect models mean little. Of those that
/// leave an immaterial part of the nominal's error, the one with the fewest effects and numbers then comes first.
void prefer_simple(Explanation& explanation, const std::vector<Measured>& data, double horizon) {
  if (explanation.excess(explanation.best().fit) < kFarFromNoise || explanation.best().fit.effects.empty()) return;
  const std::vector<Trajectory>& paths = explanation.measured->paths;
  const double noise = explanation.noise.norm() / std::sqrt(static_cast<double>(explanation.noise.size()));
  const auto beyond_noise = [&](const Fit& f) {
    const double rms = free_runs({f.plant, f.effects, {}}, data, paths, horizon, false, explanation.max_step).rms;
    return std::sqrt(std::max(0.0, rms * rms - noise * noise));
  };
  const double whole = beyond_noise(explanation.without_effects().fit);
  std::vector<std::size_t> order;
  for (std::size_t i = 0; i < explanation.candidates.size(); ++i) order.push_back(i);
  const auto size = [&](std::size_t i) {
    const Fit& f = explanation.candidates[i].fit;
    return std::pair(f.effects.size(), f.unknowns.size());
  };
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return size(a) < size(b); });
  for (const std::size_t i : order) {
    if (explanation.candidates[i].fit.effects.empty()) continue;
    if (beyond_noise(explanation.candidates[i].fit) > kMaterial * whole) continue;
    // Of sets of the same size the better one.
    std::size_t chosen = i;
    for (const std::size_t k : order) {
      if (size(k) == size(i) &&
          explanation.candidates[k].fit.log_evidence > explanation.candidates[chosen].fit.log_evidence)
        chosen = k;
    }
    Candidate simple = explanation.candidates[chosen];
    explanation.candidates.erase(explanation.candidates.begin() + static_cast<std::ptrdiff_t>(chosen));
    for (Candidate& other : explanation.candidates) other.probability = 0.0;
    simple.probability = 1.0;
    explanation.candidates.insert(explanation.candidates.begin(), std::move(simple));
    return;
  }
}

}  // namespace

Diagnosis diagnose(const DiagnosisSpec& spec) {
  const auto begun = std::chrono::steady_clock::now();
  Diagnosis result;
  ordered_json& json = result.json = skeleton();
  json["name"] = spec.name;
  json["fit"]["horizon_s"] = spec.horizon;
  const std::string unit = spec.signals.position.front().unit;
  const bool slide = spec.plant && std::holds_alternative<Mass>(*spec.plant);
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
    if (!spec.plant) {
      json["mismatch"] = mismatch;
      json["verdict"] = "unknown";
      json["reason"] = "no model: measured and simulated motion are compared, nothing is explained";
      finish();
      return result;
    }
    json["simulation_mismatch"] = mismatch;
  }

  const int joints = spec.joints();
  const Plant& nominal = *spec.plant;
  const double fastest = std::max(kFastestMode, kBandwidth * mean_frequency(all_data, first_noise));
  const ExplainOptions options{spec.effects, spec.free, kWindow * kFastestMode / fastest, fastest};
  const std::vector<Measured> data = decimated(all_data, kSamplesPerPeriod * fastest);
  Explanation explanation = explain(nominal, data, options);
  prefer_simple(explanation, data, spec.horizon);
  const Fit& best = explanation.best().fit;
  const Fit& empty = explanation.without_effects().fit;
  const Linearisation& about = *explanation.linearisation;
  json["fit"]["noise_floor"] = explanation.noise.norm() / std::sqrt(static_cast<double>(joints));

  // The nominal as given.
  const LinearResponse response_as_given(nominal, data, explanation.measured->paths, explanation.noise,
                                         about.response->windows(), options.fastest_mode);
  const FitProblem as_given{
      nominal, {}, data, response_as_given, *about.excitation, options.penalty, explanation.max_step};
  const Fit given = spec.free.empty() ? empty : fit(as_given, {});
  const double p_given = explanation.p_value(given), p_best = explanation.p_value(best);

  // Verdict.
  const bool named_something = !best.effects.empty();
  const bool significant = p_best < (named_something ? kSignificant : kNothing);
  const std::vector<Trajectory> smoothed = smooth_all(nominal, data, explanation.noise);
  const Corrected before{nominal, {}, {}}, refit{empty.plant, {}, {}};
  const Alike alike = find_alike(explanation, joints);
  const Discrepancy discrepancy(*explanation.measured, data);
  const Cleared missing = without_free(*explanation.measured, explanation.start, data, spec.free);
  Verdict verdict = named_something ? Verdict::named : Verdict::nothing_missing;
  Fit said_fit = best;  // the model that is stated
  Remainder remainder;
  Discrepancy::Dependence left;
  double share = 0.0;
  if (significant) {
    const auto beyond_noise = [&](const Fit& f) {
      const double rms =
          free_runs({f.plant, f.effects, {}}, data, smoothed, spec.horizon, false, explanation.max_step).rms;
      return std::sqrt(std::max(0.0, rms * rms - explanation.noise.squaredNorm() / joints));
    };
    share = beyond_noise(best) / std::max(beyond_noise(empty), 1e-300);
    Discrepancy::Beside odds;
    if (named_something) odds = discrepancy.beside(missing.columns, missing.target, options.penalty);
    const bool earned = named_something && odds.log_odds > kEarned;
    if (!earned || share > kMaterial) verdict = Verdict::unknown;
    left = discrepancy.dependence(missing.target);
    const Discrepancy about_best(about, data);
    const Discrepancy::Dependence beside_best = about_best.dependence(best.residual);
    if (verdict == Verdict::unknown) {
      // What other recordings are to be simulated with: what predicts each training recording from the others best.
      double lowest = kInfinity;
      const auto consider = [&](const Fit& model, const auto& remainder_without) {
        double squares = 0.0, samples = 0.0;
        for (std::size_t r = 0; r < data.size(); ++r) {
          const FreeRuns runs = free_runs({model.plant, model.effects, remainder_without(static_cast<int>(r))},
                                          {data[r]}, {smoothed[r]}, spec.horizon, false, explanation.max_step);
          squares += runs.rms * runs.rms * runs.samples;
          samples += runs.samples;
        }
        const double rms = std::sqrt(squares / samples);
        if (rms < 0.98 * lowest) {
          lowest = rms;
          said_fit = model;
          remainder = remainder_without(-1);
        }
      };
      const auto none = [](int) { return Remainder{}; };
      consider(empty, none);
      for (const bool leading_only : {true, false}) {
        consider(empty, [&](int out) { return discrepancy.remainder(missing.target, left, leading_only, out); });
      }
      if (named_something) {
        consider(best, none);
        consider(best, [&](int out) { return about_best.remainder(best.residual, beside_best, true, out); });
      }
      if (!said_fit.effects.empty()) left = beside_best;
    } else {
      left = beside_best;
      remainder = about_best.remainder(best.residual, left, false);
    }
  }
  if (verdict == Verdict::named && alike.probability < kConfident) verdict = Verdict::ambiguous;
  const Corrected corrected{said_fit.plant, said_fit.effects, {}};
  const bool say_effects = !corrected.effects.empty();
  const bool parameters_explain = verdict == Verdict::nothing_missing && p_given < kNothing && !spec.free.empty();
  const bool detected = verdict != Verdict::nothing_missing || parameters_explain;
  json["verdict"] = to_name(verdict);

  // Where.
  ordered_json& mismatch = json["mismatch"];
  mismatch["detected"] = detected;
  mismatch["p_value"] = p_given;
  mismatch["explained_by_parameters"] = parameters_explain;
  if (detected) {
    for (const Interval& interval : significant_times(explanation, data, smoothed)) {
      mismatch["time"].push_back({{"recording", data[interval.recording].name},
                                  {"from", data[interval.recording].start + interval.from},
                                  {"to", data[interval.recording].start + interval.to},
                                  {"score", interval.score}});
    }
    const Discrepancy::Dependence whole = discrepancy.dependence(missing.target);
    mismatch["depends_on"] = shares_json(whole.shares);
    mismatch["joint"] = whole.joint + 1;
    const auto lead = std::max_element(whole.shares.begin(), whole.shares.end()) - whole.shares.begin();
    mismatch["channel"] = lead == static_cast<int>(Cause::input) ? "input" : "drift";
    if (say_effects) {
      const Effect& main = best.effects[strongest(explanation)];
      mismatch["channel"] = channel(main.form);
      mismatch["joint"] = main.joint + 1;
    }
  }

  // Which.
  ordered_json& said = json["explanation"];
  if (say_effects) {
    std::string text;
    for (std::size_t e = 0; e < best.effects.size(); ++e) {
      said["effects"].push_back(effect_json(best, e, data));
      text += (text.empty() ? "" : "; ") + equation(best.effects[e], joints);
    }
    said["equation"] = text;
    said["probability"] = alike.probability;
    for (const std::vector<std::string>& names : alike.classes) {
      if (names.size() > 1) json["indistinguishable"].push_back(names);
    }
  } else {
    said["probability"] = verdict == Verdict::nothing_missing ? explanation.best().probability : 0.0;
  }
  for (const Candidate& candidate : explanation.candidates) {
    if (&candidate == &explanation.best() || candidate.probability < kShown) continue;
    json["alternatives"].push_back(
        {{"effects", labels(candidate.fit.effects, joints)}, {"probability", candidate.probability}});
    if (json["alternatives"].size() >= 10) break;
  }
  if (significant && verdict != Verdict::nothing_missing) {
    json["remainder"] = {{"share", std::min(1.0, share * share)}, {"depends_on", shares_json(left.shares)}};
  }
  for (const std::string& name : parameter_names(nominal)) {
    double value = parameter(corrected.plant, name), sd = 0.0;
    for (std::size_t i = 0; i < best.unknowns.size(); ++i) {
      if (best.unknowns[i].effect < 0 && best.unknowns[i].name == name) {
        sd = std::sqrt(std::max(0.0, best.covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(i))));
      }
    }
    json["parameters"][name] = {{"nominal", parameter(nominal, name)}, {"value", value}, {"sd", sd}};
  }

  // Fit on the training recordings.
  Corrected after = corrected;
  if (verdict == Verdict::unknown) after.remainder = remainder;
  if (verdict == Verdict::nothing_missing) after = refit;
  const auto report = [&](const std::vector<Measured>& recordings, const std::vector<Trajectory>& paths, bool held_out,
                          std::string_view set) {
    ordered_json fits = no_fit();
    const FreeRuns runs_before = free_runs(before, recordings, paths, spec.horizon, held_out, explanation.max_step);
    const FreeRuns runs_after = free_runs(after, recordings, paths, spec.horizon, held_out, explanation.max_step);
    fits["before"] = runs_before.rms;
    fits["refit"] = spec.free.empty()
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
  json["next_experiment"] = propose(nominal, explanation, data, joints);

  // Hold out: only now.
  if (!spec.held_out.empty()) {
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
