#include "sim/sensor.hpp"

#include <algorithm>

namespace bayesctrl {

Measurement::Measurement(const Sensor& sensor, double dt, int joints, std::size_t samples, RandomStream random)
    : sensor_(sensor), dt_(dt), measured_(3, StateVector::Zero(2 * joints)), random_(random) {
  if (sensor_.delay_periods > 0) truth_.reserve(samples);
}

StateVector Measurement::operator()(const StateVector& truth) {
  if (sensor_.delay_periods == 0) return measure(truth);
  truth_.push_back(truth);
  const auto delay = static_cast<std::size_t>(sensor_.delay_periods);
  return measure(truth_[truth_.size() > delay ? truth_.size() - 1 - delay : 0]);
}

StateVector Measurement::measure(const StateVector& truth) {
  const Eigen::Index n = truth.size() / 2;
  StateVector seen = truth;
  for (Eigen::Index i = 0; i < n; ++i) {
    if (sensor_.noise > 0.0) seen[i] += sensor_.noise * draw_normal(random_);
    if (sensor_.quantum > 0.0) seen[i] = std::round(seen[i] / sensor_.quantum) * sensor_.quantum;
    if (sensor_.velocity_noise > 0.0) seen[n + i] += sensor_.velocity_noise * draw_normal(random_);
  }
  if (!sensor_.positions_only) return seen;

  std::rotate(measured_.begin(), measured_.begin() + 1, measured_.end());
  measured_.back() = seen;
  ++calls_;
  const auto q = [&](std::size_t age) { return measured_[2 - age].head(n); };
  if (calls_ == 1) {
    seen.tail(n).setZero();  // one position says nothing of the velocity
  } else if (calls_ == 2) {
    seen.tail(n) = (q(0) - q(1)) / dt_;
  } else {
    seen.tail(n) = (3.0 * q(0) - 4.0 * q(1) + q(2)) / (2.0 * dt_);  // second order, no sample of the future
  }
  return seen;
}

}  // namespace bayesctrl
