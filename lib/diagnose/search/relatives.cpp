#include "diagnose/search/relatives.hpp"

#include <algorithm>
#include <optional>

#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// A law and the laws that reduce to it, of each the middle one of its starts; with none, nothing.
std::vector<EffectForm> laws_about(const EffectForm& simplest) {
  std::vector<EffectForm> laws{simplest};
  for (const EffectLaw* law : catalogue()) {
    if (law->simpler_law() != &simplest.law()) continue;
    const std::vector<EffectForm> starts = law->extending(simplest);
    laws.push_back(starts[starts.size() / 2]);
  }
  return laws.size() > 1 ? laws : std::vector<EffectForm>{};
}

}  // namespace

std::string label(const Effect& effect, int joints) {
  std::string text(name_of(effect.form));
  if (joints > 1) text += "@" + std::to_string(effect.joint + 1);
  return effect.form.roles().of_one_recording ? text + "#" + std::to_string(effect.recording + 1) : text;
}

std::string key(const std::vector<Effect>& effects) {
  std::vector<std::string> names;
  for (const Effect& effect : effects) {
    names.push_back(label(effect, 2) + (effect.recording >= 0 ? " " + std::to_string(effect.recording) : ""));
  }
  std::sort(names.begin(), names.end());
  std::string text;
  for (const std::string& name : names) text += name + " ";
  return text;
}

std::vector<Effect> without(std::vector<Effect> set, std::size_t effect) {
  set.erase(set.begin() + static_cast<std::ptrdiff_t>(effect));
  return set;
}

bool simplify(EffectForm& form) {
  const std::optional<EffectForm> simpler = form.law().simpler(form);
  if (simpler) form = *simpler;
  return simpler.has_value();
}

std::vector<std::vector<Effect>> simpler_sets(const std::vector<Effect>& effects) {
  std::vector<std::vector<Effect>> list;
  for (std::size_t e = 0; e < effects.size(); ++e) {
    list.push_back(without(effects, e));
    std::vector<Effect> simpler = effects;
    if (simplify(simpler[e].form)) list.push_back(std::move(simpler));
  }
  return list;
}

std::vector<Effect> start_from(const std::vector<Effect>& known, std::vector<Effect> wanted) {
  for (Effect& effect : wanted) {
    for (const Effect& other : known) {
      if (same_kind(effect, other)) effect = other;
    }
  }
  return wanted;
}

std::vector<std::vector<Effect>> law_relatives(const std::vector<Effect>& set) {
  std::vector<std::vector<Effect>> list;
  for (std::size_t e = 0; e < set.size(); ++e) {
    std::vector<Effect> plain = set;
    while (simplify(plain[e].form)) {
    }
    for (const EffectForm& form : laws_about(plain[e].form)) {
      std::vector<Effect> swapped = set;
      swapped[e].form = form;
      if (&form.law() != &set[e].form.law()) list.push_back(std::move(swapped));
    }
    for (const EffectForm& form : laws_about(plain[e].form.law().scaled(plain[e].form, kSettings.search.second_law))) {
      std::vector<Effect> larger = set;
      larger.push_back({form, set[e].joint, -1});
      if (&form.law() != &set[e].form.law() && larger.size() <= std::size_t{kSettings.search.largest_set})
        list.push_back(std::move(larger));
    }
  }
  return list;
}

std::vector<std::vector<Effect>> equivalents(const std::vector<Effect>& set) {
  std::vector<std::vector<Effect>> list;
  for (std::size_t e = 0; e < set.size(); ++e) {
    const std::optional<EffectForm> other = equivalent(set[e].form);
    if (!other) continue;
    list.push_back(set);
    list.back()[e].form = *other;
  }
  return list;
}

std::vector<std::vector<Effect>> starts_from(const std::vector<Effect>& wanted, const std::vector<Effect>& other) {
  for (std::size_t drop = 0; drop < other.size(); ++drop) {
    if (key(without(other, drop)) == key(wanted)) return {without(other, drop)};
  }
  for (std::size_t e = 0; e < other.size(); ++e) {
    std::vector<Effect> simpler = other;
    if (simplify(simpler[e].form) && key(simpler) == key(wanted)) return {simpler};
  }
  for (const std::vector<Effect>& equivalent : equivalents(other)) {
    if (key(equivalent) == key(wanted)) return {equivalent};
  }
  std::vector<std::vector<Effect>> starts;
  for (std::size_t e = 0; e < wanted.size(); ++e) {
    std::vector<Effect> simpler = wanted;
    if (!simplify(simpler[e].form) || key(simpler) != key(other)) continue;
    const auto law =
        std::find_if(other.begin(), other.end(), [&](const Effect& o) { return same_kind(o, simpler[e]); });
    for (const EffectForm& form : wanted[e].form.law().extending(law->form)) {
      std::vector<Effect> start = other;
      start[static_cast<std::size_t>(law - other.begin())].form = form;
      starts.push_back(std::move(start));
    }
  }
  return starts;
}

}  // namespace bayesctrl
