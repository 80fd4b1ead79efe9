#include "physics/effect.hpp"

namespace bayesctrl {

std::vector<double> spread(double low, double high, int count) {
  std::vector<double> values;
  for (int i = 0; i < count && low > 0.0 && high > low; ++i) {
    values.push_back(low * std::pow(high / low, static_cast<double>(i) / (count - 1)));
  }
  return values;
}

std::string_view channel(const EffectForm& form) {
  return std::visit(
      []<class E>(const E&) -> std::string_view {
        if (SensorEffect<E>) return "sensor";
        return DelayEffect<E> || MapEffect<E> || PlayEffect<E> || LagEffect<E> ? "input" : "drift";
      },
      form);
}

}  // namespace bayesctrl
