#include "physics/machine/drive.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr double kShort = 5e-3;  // time constants: over less, differences of exponentials are rounded away

}  // namespace

Line decaying(double value, double tau, double h) {
  const double x = h / tau, lost = -std::expm1(-x);
  const double rise =
      x < kShort ? -x * (1.0 - x * (0.5 - 0.15 * x)) : 12.0 * ((lost - x * (1.0 - lost)) / (x * x) - lost / (2.0 * x));
  return {value * lost / x, value * rise / h};
}

Drive::Drive(const std::vector<Effect>& effects, int joint, std::optional<double> play) : departure_(play) {
  for (const EffectLaw* law : catalogue()) {
    if (!law->roles.on_input()) continue;
    for (const Effect& effect : effects) {
      if (effect.joint != joint || &effect.form.law() != law) continue;
      delay_ += effect.form.delay_time();
      if (law->roles.lag) lag_ = effect.form.lag();
      if (law->roles.map || law->roles.play) effects_.push_back(effect.form);
    }
  }
  play_.resize(effects_.size(), 0.0);
}

Eigen::VectorXd FineInput::held(const Eigen::VectorXd& values, Eigen::Index samples) const {
  Eigen::VectorXd sums = Eigen::VectorXd::Zero(samples + 1);  // and what the last hands on
  for (std::size_t k = 0; k < static_cast<std::size_t>(values.size()); ++k) {
    const double value = values[static_cast<Eigen::Index>(k)];
    sums[stays[k]] += own[k] * value;
    sums[stays[k] + 1] += late[k] * value;
  }
  return sums.head(samples);
}

Drive::Drive(const std::vector<double>& time, const std::vector<double>& input, const std::vector<Effect>& effects,
             int joint, const FineInput* fine, std::optional<double> play)
    : Drive(effects, joint, play) {
  if (fine == nullptr || effects_.empty()) {
    for (std::size_t k = 0; k < time.size(); ++k) append(time[k], input[k]);
    return;
  }
  if (delay_ > 0.0) hold(time.front(), mapped(0.0));
  const auto samples = static_cast<Eigen::Index>(time.size());
  const auto rows = std::ranges::lower_bound(fine->stays, samples) - fine->stays.begin();
  Eigen::VectorXd values = fine->input.col(joint).head(rows);
  for (double& u : values) u = mapped(u);
  values = fine->held(values, samples);
  for (std::size_t k = 0; k < time.size(); ++k) hold(time[k] + delay_, values[static_cast<Eigen::Index>(k)]);
}

double Drive::mapped(double u) {
  for (std::size_t i = 0; i < effects_.size(); ++i) {
    u = effects_[i].transform(u);
    if (effects_[i].roles().play) u = play_[i] = effects_[i].follow(u, departure_ ? u + *departure_ : play_[i]);
  }
  departure_.reset();
  return u;
}

void Drive::hold(double time, double mapped) {
  if (lag_ > 0.0) lagged_.push_back(time_.empty() ? mapped : at(time_.size() - 1, time));
  time_.push_back(time);
  held_.push_back(mapped);
}

void Drive::append(double time, double input) {
  if (delay_ > 0.0 && time_.empty()) hold(time, mapped(0.0));
  hold(time + delay_, mapped(input));
}

double Drive::at(std::size_t index, double t) const {
  if (lagged_.empty()) return held_[index];
  return held_[index] + (lagged_[index] - held_[index]) * std::exp(-(t - time_[index]) / lag_);
}

Line Drive::over(std::size_t index, double t, double h) const {
  if (lagged_.empty()) return {held_[index], 0.0};
  Line line = decaying(at(index, t) - held_[index], lag_, h);
  line.middle += held_[index];
  return line;
}

}  // namespace bayesctrl
