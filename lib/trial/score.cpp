#include "trial/score.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "diagnose/verdict/where.hpp"
#include "physics/effect.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl::trial {

namespace {

using nlohmann::ordered_json;
using Set = std::multiset<std::string>;

constexpr double kMatters = 0.02;   // probability of an alternative
constexpr double kTwoSided = 1.96;  // deviations of a 95 % interval

int joints_of(const ordered_json& truth, const Diagnosis& d) { return truth.value("joints", d.joints); }

Set names_of_truth(const ordered_json& truth, int joints) {
  Set names;
  for (const ordered_json& effect : truth["effects"]) {
    ExplainedEffect hidden;
    hidden.name = effect["name"];
    hidden.joint = effect["joint"];
    if (effect.contains("recording_number")) hidden.recording_number = effect["recording_number"];
    names.insert(label(hidden, joints));
  }
  return names;
}

Set names_of_effects(const std::vector<ExplainedEffect>& effects, int joints) {
  Set names;
  for (const ExplainedEffect& effect : effects) names.insert(label(effect, joints));
  return names;
}

/// How many names of what was said are in the truth, as themselves or as one of at most three names that were said to
/// be inseparable. Each of the truth counts once.
std::size_t matches(const Set& truth, const Set& said, const std::vector<std::vector<std::string>>& classes) {
  Set lost, won;
  std::set_difference(truth.begin(), truth.end(), said.begin(), said.end(), std::inserter(lost, lost.end()));
  std::set_difference(said.begin(), said.end(), truth.begin(), truth.end(), std::inserter(won, won.end()));
  for (const std::vector<std::string>& list : classes) {
    if (list.size() > 3) continue;
    const auto inside = [&](const std::string& name) {
      return std::find(list.begin(), list.end(), name) != list.end();
    };
    const auto a = std::find_if(lost.begin(), lost.end(), inside), b = std::find_if(won.begin(), won.end(), inside);
    if (a != lost.end() && b != won.end()) {
      lost.erase(a);
      won.erase(b);
    }
  }
  return said.size() - won.size();
}

std::string join(const Set& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : " + ") + name;
  return text.empty() ? "-" : text;
}

/// Family, label and sizes of what was hidden.
void describe(Scored& s, const ordered_json& truth) {
  s.family = truth["family"];
  s.noise = truth["noise"];
  const bool outside = truth.contains("outside");
  s.label = s.family == "outside"   ? truth["outside"]["name"].get<std::string>()
            : s.family == "grammar" ? truth["outside"]["cause"].get<std::string>()
            : s.family == "single"  ? truth["effects"][0]["name"].get<std::string>()
                                    : s.family;
  s.size = outside ? truth["outside"]["size"].get<double>() : 0.0;
  for (const ordered_json& effect : truth["effects"]) {
    s.size = s.size == 0.0 ? effect["size"].get<double>() : std::min(s.size, effect["size"].get<double>());
  }
}

/// Whether the truth is the explanation or one of the alternatives that matter, at most three sets in all.
bool is_among(const Set& truth, bool right, const std::vector<Alternative>& alternatives) {
  int sets = 1;
  for (const Alternative& other : alternatives) {
    if (!(other.probability >= kMatters)) continue;
    if (++sets <= 3 && Set(other.effects.begin(), other.effects.end()) == truth) right = true;
  }
  return right;
}

/// Whether what was said is what was hidden.
void judge_names(Scored& s, const ordered_json& truth, const Diagnosis& d) {
  const int joints = joints_of(truth, d);
  const Set wanted = names_of_truth(truth, joints), said = names_of_effects(d.explanation.effects, joints);
  s.said = join(said);
  s.hidden = truth.contains("outside") ? truth["outside"]["name"].get<std::string>() : join(wanted);
  const bool right =
      !wanted.empty() && wanted.size() == said.size() && matches(wanted, said, d.indistinguishable) == said.size();
  if (s.confident) s.named = right;
  if (s.verdict == Verdict::ambiguous) s.named = is_among(wanted, right, d.alternatives);
  s.wrong = s.confident && !right;
}

/// How many effects are listed as certain, and how many of them were hidden.
void judge_certain(Scored& s, const ordered_json& truth, const Diagnosis& d) {
  const int joints = joints_of(truth, d);
  std::vector<ExplainedEffect> certain = d.explanation.effects;
  std::erase_if(certain, [](const ExplainedEffect& e) { return !(e.inclusion.value_or(0.0) >= kCertain); });
  const Set said = names_of_effects(certain, joints);
  s.certain = static_cast<int>(said.size());
  s.effects = static_cast<int>(truth["effects"].size());
  s.certain_right = static_cast<int>(matches(names_of_truth(truth, joints), said, d.indistinguishable));
}

void judge_cause(Scored& s, const ordered_json& outside, const Mismatch& mismatch) {
  const std::string lead(to_name(mismatch.depends_on.leading()));
  s.joint = mismatch.joint && *mismatch.joint == outside["joint"].get<int>();
  s.cause = lead == outside["cause"] || lead == outside.value("also", "");
  s.detail = {{"lead", lead}, {"cause", outside["cause"]}};
}

/// An effect of the catalogue by its name, as declared.
EffectForm effect_named(std::string_view name) {
  const std::vector<std::string_view> names = effect_names();
  return declared_effect(static_cast<std::size_t>(std::ranges::find(names, name) - names.begin()));
}

/// Counts the parameters of an effect that was found, and the intervals that hold the truth.
void judge_parameters(Scored& s, const ordered_json& hidden, const ExplainedEffect& found) {
  std::map<std::string, double, std::less<>> cycles;  // of angles
  for (const Declared& one : parameters(effect_named(found.name))) {
    cycles.emplace(one.name, one.info.search.cycle);
  }
  for (const auto& [name, estimate] : found.parameters.items) {
    if (!(estimate.sd > 0.0)) continue;
    double error = estimate.value - hidden["parameters"][name].get<double>();
    if (const double cycle = cycles.at(name); cycle > 0.0) error = std::remainder(error, cycle);
    ++s.parameters;
    s.covered += std::abs(error) <= kTwoSided * estimate.sd;
  }
}

/// How far from a step in time the nearest interval of its recording begins, s.
double step_error(const ordered_json& step, const std::vector<TimeSpan>& times) {
  double least = 1e9;
  for (const TimeSpan& span : times) {
    if (span.recording != step["recording"]) continue;
    least = std::min(least, std::abs(span.from - step["parameters"]["time"].get<double>()));
  }
  return least;
}

/// Whether channel and joint are those of a hidden effect, and how near its parameters are.
void judge_place(Scored& s, const ordered_json& effects, const Diagnosis& d) {
  const Mismatch& mismatch = d.mismatch;
  for (const ordered_json& effect : effects) {
    const int joint = effect["joint"];
    if (mismatch.channel == channel_of(effect_named(effect["name"].get<std::string>()))) s.channel = true;
    s.joint = s.joint || mismatch.joint == joint;
    for (const ExplainedEffect& found : d.explanation.effects) {
      if (effect["name"] == found.name && joint == found.joint) judge_parameters(s, effect, found);
    }
    if (effect_named(effect["name"].get<std::string>()).roles().timed) s.step_error = step_error(effect, mismatch.time);
  }
}

}  // namespace

Scored score(const std::string& name, const ordered_json& truth, const Diagnosis& d) {
  Scored s;
  s.name = name;
  describe(s, truth);
  s.verdict = d.verdict;
  s.seconds = d.seconds;
  s.probability = d.explanation.probability;
  s.detected = d.mismatch.detected && s.verdict != Verdict::nothing_missing;
  s.confident = s.verdict == Verdict::named;
  s.declined = s.verdict == Verdict::unknown;
  judge_names(s, truth, d);
  judge_certain(s, truth, d);
  const FitErrors& errors = d.fit.held_out;
  const auto over_noise = [&](const std::optional<double>& error) {
    return error.value_or(std::nan("")) / std::max(s.noise, 1e-12);
  };
  s.before = over_noise(errors.before);
  s.refit = over_noise(errors.refit);
  s.after = over_noise(errors.after);
  if (s.family == "short") s.detail = {{"level", truth["level"]}};
  if (s.family == "cut") s.detail = {{"length", truth["length"]}};
  if (s.family == "nonsense") s.detail = {{"motion", truth["motion"]}};
  judge_place(s, truth["effects"], d);
  if (truth.contains("outside")) {
    s.channel = false;
    judge_cause(s, truth["outside"], d.mismatch);
  }
  return s;
}

}  // namespace bayesctrl::trial
