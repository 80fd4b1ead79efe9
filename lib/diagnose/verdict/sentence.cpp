#include "diagnose/verdict/sentence.hpp"

#include <algorithm>
#include <functional>

#include "base/format.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// "Coulomb friction" of "coulomb_friction", also where a joint follows; "recording gain of recording 2" of
/// "recording_gain@1#2".
std::string in_words(std::string name) {
  const std::size_t number = name.find('#');
  const std::string recording = number == std::string::npos ? "" : " of recording " + name.substr(number + 1);
  name = name.substr(0, name.find_first_of("@#")) + recording;
  std::ranges::replace(name, '_', ' ');
  if (name.starts_with("coulomb") || name.starts_with("stribeck")) name[0] += 'A' - 'a';  // people
  return name;
}

/// "a, b and c"
std::string enumerated(const std::vector<std::string>& list, std::string_view last) {
  std::string text;
  for (std::size_t i = 0; i < list.size(); ++i) {
    text += std::string(i == 0 ? "" : i + 1 == list.size() ? last : ", ") + list[i];
  }
  return text;
}

/// " or actuator lag": what the recordings cannot separate from an effect.
std::string or_alike(const Diagnosis& d, const ExplainedEffect& effect) {
  for (const std::vector<std::string>& alike : d.indistinguishable) {
    if (alike.empty() || alike.front() != label(effect, d.joints)) continue;
    std::string others;
    for (std::size_t i = 1; i < alike.size(); ++i) others += (i > 1 ? " or " : "") + in_words(alike[i]);
    if (!others.empty()) return " or " + others;
  }
  return "";
}

/// "forward 167, backward 245 N s/m": the first, and what is of its kind.
std::string in_words(const Named<Estimate>& parameters) {
  const std::string& unit = parameters.items.front().second.unit;
  std::string text;
  for (const auto& [name, estimate] : parameters.items) {
    if (!text.empty() && (unit.empty() || estimate.unit != unit)) continue;
    text += (text.empty() ? "" : ", ") + in_words(name) + " " + format(estimate.value, 3);
  }
  return unit.empty() ? text : text + " " + unit;
}

/// "Coulomb friction or Stribeck friction in joint 2 (level 0.186 N m, 23 % of the error)".
std::string in_words(const Diagnosis& d, const ExplainedEffect& effect, bool with_share) {
  std::string text = in_words(effect.name), in_brackets;
  if (effect.recording) text += " of " + *effect.recording;
  text += or_alike(d, effect);
  if (d.joints > 1) text += " in joint " + std::to_string(effect.joint);
  if (!effect.parameters.items.empty()) in_brackets = in_words(effect.parameters);
  if (with_share && effect.share) {
    in_brackets += (in_brackets.empty() ? "" : ", ") + share_text(*effect.share) + " of the error";
  }
  return in_brackets.empty() ? text : text + " (" + in_brackets + ")";
}

bool is_certain(const ExplainedEffect& effect) { return effect.inclusion.value_or(0.0) >= kSettings.verdict.confident; }

/// Whether an effect is there, but hardly matters.
bool is_trace(const ExplainedEffect& effect) { return effect.share && *effect.share < kSettings.verdict.trace; }

bool weighs(const ExplainedEffect& effect) { return is_certain(effect) && !is_trace(effect); }

/// Those of them that are wanted.
std::string in_words(const Diagnosis& d, const std::function<bool(const ExplainedEffect&)>& wanted, bool with_share) {
  std::vector<std::string> list;
  for (const ExplainedEffect& effect : d.explanation.effects) {
    if (wanted(effect)) list.push_back(in_words(d, effect, with_share));
  }
  return enumerated(list, " and ");
}

/// " With it simulations err by 0.124 mm instead of 3.69 mm, 30 times less.": of what was held out, if anything was.
std::string gain(const Diagnosis& d) {
  const FitErrors& errors = d.fit.judged();
  if (!errors.after || !errors.refit || !(*errors.after < 0.9 * *errors.refit)) return "";
  constexpr double kNearly = 1.1;
  const bool down = *errors.after < kNearly * d.fit.noise_floor;
  const double times = *errors.refit / *errors.after;
  return " With it simulations err by " + format(*errors.after, 3) + " " + d.fit.unit + " instead of " +
         format(*errors.refit, 3) + " " + d.fit.unit + ", " +
         (down ? "which is the sensor's noise." : format(times, times < 100.0 ? 2 : 3) + " times less.");
}

/// "depends on the velocity most".
std::string depends(const CauseShares& on) {
  if (!(on.largest() > 0.0)) return "";
  const Cause cause = on.leading();
  return "depends on " + (cause == Cause::history ? "what was before" : "the " + std::string(to_name(cause))) + " most";
}

/// " There are traces of ...": of what is certain but hardly matters.
std::string traces(const Diagnosis& d) {
  const std::string text = in_words(
      d, [](const ExplainedEffect& e) { return is_certain(e) && is_trace(e); }, true);
  return text.empty() ? "" : " There are traces of " + text + ".";
}

/// "constant bias, Coulomb friction or viscous friction"
std::string in_words(const Alone& alone, int joints) {
  std::vector<std::string> list;
  for (const auto& [name, share] : alone.effects.items) {
    list.push_back(
        in_words(name) +
        (joints > 1 ? " in joint " + name.substr(name.find('@') + 1, name.find('#') - name.find('@') - 1) : ""));
  }
  return enumerated(list, " or ");
}

/// " Any of these alone would take away nearly all of it: ...", where there are such.
std::string open_laws(const Diagnosis& d) {
  if (!d.alone) return "";
  const bool one_way = d.alone->one_way;
  return " Any of these alone would take away nearly all of it: " + in_words(*d.alone, d.joints) +
         ". The recordings hardly tell them apart" +
         (one_way ? ", as the joint moves one way only: record it both ways and at several speeds." : ".");
}

/// What is certain, what else there is, and what may be part of it.
std::string unexplained(const Diagnosis& d) {
  if (d.alone) return "Something is missing." + open_laws(d) + traces(d);
  const std::string certain = in_words(d, weighs, true), perhaps = in_words(d, std::not_fn(is_certain), false);
  std::string on = depends(certain.empty() || !d.remainder ? d.mismatch.depends_on : d.remainder->depends_on);
  if (!on.empty()) on = certain.empty() ? "; it " + on : ", which " + on;
  std::string text = certain.empty() ? "Something is missing that no known effect explains"
                                     : "Certain: " + certain + ". Something else is missing";
  text += on + "." + traces(d);
  return perhaps.empty() ? text : text + " Perhaps part of it: " + perhaps + ".";
}

/// Of all that is listed, with what one effect is.
std::string lacking(const Diagnosis& d) {
  const std::vector<ExplainedEffect>& effects = d.explanation.effects;
  const std::string text = effects.size() == 1 ? effects.front().text : "";
  const bool only_traces = std::ranges::all_of(effects, is_trace);
  const auto main = [&](const ExplainedEffect& e) { return is_certain(e) && (only_traces || !is_trace(e)); };
  return "The model lacks " + in_words(d, main, false) + (text.empty() ? "" : ": " + text) + "." +
         (only_traces ? "" : traces(d)) + gain(d);
}

}  // namespace

bool has_certain(const Diagnosis& d) { return std::ranges::any_of(d.explanation.effects, weighs); }

std::string sentence(const Diagnosis& d) {
  const std::string sure = percent_text(d.explanation.probability);
  switch (d.verdict) {
    case Verdict::named:
      return lacking(d) + " Probability " + sure + ".";
    case Verdict::ambiguous: {
      const std::string certain = in_words(d, weighs, false), rest = in_words(d, std::not_fn(is_certain), false);
      return "Something is missing, most probably " + certain + (certain.empty() || rest.empty() ? "" : " and ") +
             rest + " (" + sure + "), but not surely." + open_laws(d) + traces(d);
    }
    case Verdict::nothing_missing:
      return d.mismatch.explained_by_parameters
                 ? "No physics is missing: other values of the free parameters explain the recordings."
                 : "Nothing is missing: the model explains the recordings down to the sensor's noise.";
    case Verdict::too_little_data:
      return "The recordings say too little for a diagnosis.";
    case Verdict::check_spec:
      return d.suspicions.empty() ? "The recordings do not fit the spec: check its units, signs and columns first."
                                  : "Check the spec. " + d.suspicions.front().sentence;
    case Verdict::unknown:
      break;
  }
  return unexplained(d);
}

}  // namespace bayesctrl
