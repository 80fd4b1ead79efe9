#include "physics/drive.hpp"

#include <cmath>

namespace bayesctrl {

namespace {

void delay_by(double delay, std::vector<double>& time, std::vector<double>& value) {
  if (delay <= 0.0) return;
  const double start = time.front();
  for (double& t : time) t += delay;
  time.insert(time.begin(), start);
  value.insert(value.begin(), 0.0);
}

}  // namespace

Drive::Drive(const std::vector<double>& time, const std::vector<double>& input, const std::vector<Effect>& effects,
             int joint)
    : time_(time), held_(input) {
  const auto apply = [&]<class E>(const E& effect) {
    if constexpr (DelayEffect<E>) delay_by(effect.delay_time(), time_, held_);
    if constexpr (MapEffect<E>) {
      for (double& u : held_) u = effect.transform(u);
    }
    if constexpr (PlayEffect<E>) {
      double output = 0.0;
      for (double& u : held_) u = output = effect.follow(u, output);
    }
    if constexpr (LagEffect<E>) lag_ = effect.lag();
  };
  for (std::size_t kind = 0; kind < std::variant_size_v<EffectForm>; ++kind) {
    for (const Effect& effect : effects) {
      if (effect.joint == joint && effect.form.index() == kind) std::visit(apply, effect.form);
    }
  }
  if (lag_ <= 0.0) return;
  lagged_.resize(held_.size(), held_.front());
  for (std::size_t k = 1; k < held_.size(); ++k) lagged_[k] = at(k - 1, time_[k]);
}

double Drive::at(std::size_t index, double t) const {
  if (lag_ <= 0.0) return held_[index];
  return held_[index] + (lagged_[index] - held_[index]) * std::exp(-(t - time_[index]) / lag_);
}

}  // namespace bayesctrl
