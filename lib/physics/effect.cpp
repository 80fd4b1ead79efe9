#include "physics/effect.hpp"

namespace bayesctrl {

std::vector<double> spread(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count && low > 0.0 && high > low; ++i) {
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / (count - 1)));
  }
  return values;
}

bool same_kind(const Effect& a, const Effect& b) {
  return a.form.index() == b.form.index() && a.joint == b.joint && a.recording == b.recording;
}

double spring_torque(const std::vector<Effect>& effects, int joint, double position) {
  double torque = 0.0;
  for (const Effect& effect : effects) {
    if (effect.joint != joint) continue;
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (SpringEffect<E>) torque += form.torque_at({.position = position});
        },
        effect.form);
  }
  return torque;
}

bool redundant(const std::vector<Effect>& effects) {
  for (const Effect& law : effects) {
    for (const Effect& other : effects) {
      if (&other != &law && same_kind(other, law)) return true;
    }
    const bool found = std::visit(
        [&]<class E>(const E&) {
          if constexpr (requires { typename E::Contains; }) {
            for (const Effect& other : effects) {
              if (other.joint == law.joint && std::holds_alternative<typename E::Contains>(other.form)) return true;
            }
          }
          return false;
        },
        law.form);
    if (found) return true;
  }
  return false;
}

std::optional<EffectForm> equivalent(const EffectForm& form) {
  return std::visit(
      []<class E>(const E& held) -> std::optional<EffectForm> {
        if constexpr (requires { held.equivalent(); }) return held.equivalent();
        std::optional<EffectForm> found;
        for_each_alternative(static_cast<const EffectForm*>(nullptr), [&]<class Other>(const Other&) {
          if constexpr (requires { Other::equivalent_of(held); }) found = Other::equivalent_of(held);
        });
        return found;
      },
      form);
}

int least_joints(const EffectForm& form) {
  return std::visit(
      []<class E>(const E&) {
        if constexpr (requires { E::kLeastJoints; }) return E::kLeastJoints;
        return 1;
      },
      form);
}

int hidden_count(const EffectForm& form) {
  return std::visit([]<class E>(const E&) { return hidden_count<E>(); }, form);
}

int hidden_count(const std::vector<Effect>& effects) {
  int count = 0;
  for (const Effect& effect : effects) count += hidden_count(effect.form);
  return count;
}

std::string_view channel(const EffectForm& form) {
  return std::visit([]<class E>(const E&) { return channel_of<E>(); }, form);
}

}  // namespace bayesctrl
