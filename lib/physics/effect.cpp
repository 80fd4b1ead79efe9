#include "physics/effect.hpp"

namespace bayesctrl {

std::string_view channel(const EffectForm& form) {
  return std::visit(
      []<class E>(const E&) -> std::string_view {
        if (SensorEffect<E>) return "sensor";
        return DelayEffect<E> || MapEffect<E> || PlayEffect<E> || LagEffect<E> ? "input" : "drift";
      },
      form);
}

}  // namespace bayesctrl
