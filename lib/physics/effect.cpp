#include "physics/effect.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <variant>

namespace bayesctrl {

std::vector<double> spread(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count && low > 0.0 && high > low; ++i) {
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / (count - 1)));
  }
  return values;
}

const EffectLaw& law_of(const void* type) {
  for (const EffectLaw* law : catalogue()) {
    if (law->type == type) return *law;
  }
  throw std::invalid_argument("an effect that is not in the catalogue");
}

std::vector<double> multiples(double step, double highest) {
  std::vector<double> values;
  for (double value = 2.0 * step; value < highest; value += step) values.push_back(value);
  return values;
}

EffectForm::EffectForm() : EffectForm(declared_effect(0)) {}

std::size_t EffectForm::index() const {
  return static_cast<std::size_t>(std::ranges::find(catalogue(), law_) - catalogue().begin());
}

void EffectForm::refuse() { throw std::bad_variant_access(); }

std::vector<std::string_view> effect_names() {
  std::vector<std::string_view> names;
  for (const EffectLaw* law : catalogue()) names.push_back(law->name);
  return names;
}

std::vector<std::size_t> usual_effects() {
  std::vector<std::size_t> list;
  for (std::size_t kind = 0; kind < catalogue().size(); ++kind) {
    const EffectRoles& roles = catalogue()[kind]->roles;
    if (!roles.on_demand && !roles.feels_temperature) list.push_back(kind);
  }
  return list;
}

bool same_kind(const Effect& a, const Effect& b) {
  return &a.form.law() == &b.form.law() && a.joint == b.joint && a.recording == b.recording;
}

bool same_place(const Effect& a, const Effect& b) {
  return &a.form.law() == &b.form.law() && a.joint == b.joint &&
         (!a.form.roles().of_one_recording || a.recording == b.recording);
}

std::vector<Effect> acting_in(const std::vector<Effect>& effects, std::size_t recording) {
  std::vector<Effect> here;
  std::ranges::copy_if(effects, std::back_inserter(here),
                       [&](const Effect& effect) { return effect.acts_in(recording); });
  return here;
}

std::vector<Effect> in_new_recordings(std::vector<Effect> effects) {
  std::erase_if(effects, [](const Effect& effect) { return effect.form.roles().of_one_recording; });
  for (Effect& effect : effects) effect.recording = -1;
  return effects;
}

bool feel_temperature(const std::vector<Effect>& effects) {
  return std::ranges::any_of(effects, [](const Effect& effect) { return effect.form.roles().feels_temperature; });
}

double spring_torque(const std::vector<Effect>& effects, int joint, double position) {
  double torque = 0.0;
  for (const Effect& effect : effects) {
    if (effect.joint == joint && effect.form.roles().spring) torque += effect.form.torque_at({.position = position});
  }
  return torque;
}

bool redundant(const std::vector<Effect>& effects) {
  for (const Effect& law : effects) {
    for (const Effect& other : effects) {
      if (&other != &law && same_kind(other, law)) return true;
      if (other.joint == law.joint && &other.form.law() == law.form.law().contained()) return true;
    }
  }
  return false;
}

std::optional<EffectForm> equivalent(const EffectForm& form) {
  std::optional<EffectForm> found = form.law().equivalent(form);
  for (const EffectLaw* law : catalogue()) {
    if (found) break;
    found = law->equivalent_of(form);
  }
  return found;
}

int hidden_count(const std::vector<Effect>& effects) {
  int count = 0;
  for (const Effect& effect : effects) count += effect.form.law().hidden_count;
  return count;
}

std::string_view channel(const EffectForm& form) {
  if (form.roles().sensor) return "sensor";
  return form.roles().on_input() ? "input" : "drift";
}

}  // namespace bayesctrl
