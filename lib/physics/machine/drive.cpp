#include "physics/machine/drive.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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

Drive::Drive(const std::vector<Effect>& effects, int joint) {
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

InputSpread::InputSpread(const FineInput& fine, const Eigen::VectorXd& values, Eigen::Index samples)
    : samples_(static_cast<std::size_t>(samples) + 1) {
  const auto rows = static_cast<std::size_t>(values.size());
  std::size_t before = 0, begin = 0, end = 0;  // rows of the sample before, and of this one
  for (std::size_t i = 0; i + 1 < samples_.size(); ++i) {
    Held& held = samples_[i];
    const auto add = [&](std::size_t row, double weight) {
      const double u = values[static_cast<Eigen::Index>(row)];
      values_.push_back({u, weight});
      held.mean += weight * u;
      held.lowest = std::min(held.lowest, u);
      held.highest = std::max(held.highest, u);
    };
    while (end < rows && fine.stays[end] == static_cast<Eigen::Index>(i)) ++end;
    for (std::size_t row = before; row < begin; ++row) {
      if (fine.late[row] != 0.0) add(row, fine.late[row]);
    }
    for (std::size_t row = begin; row < end; ++row) add(row, fine.own[row]);
    samples_[i + 1].first = values_.size();
    before = std::exchange(begin, end);
  }
}

double InputSpread::unsteady(std::size_t sample, double from) const {
  if (sample + 1 >= samples_.size()) return 0.0;
  const Held& held = samples_[sample];
  if (from <= held.lowest || from >= held.highest) return 0.0;  // |u - from| is linear in u
  double mean = 0.0;
  for (std::size_t i = held.first; i < samples_[sample + 1].first; ++i) {
    mean += values_[i].weight * std::abs(values_[i].u - from);
  }
  return std::max(0.0, mean - std::abs(held.mean - from));
}

Drive::Drive(const std::vector<double>& time, const std::vector<double>& input, const std::vector<Effect>& effects,
             int joint, const FineInput* fine, const Restarts& restarts)
    : Drive(effects, joint) {
  auto next = restarts.begin();
  const auto reach = [&](std::size_t sample) {
    for (; next != restarts.end() && next->sample <= sample; ++next) {
      if (joint < next->plays.size()) departure_ = next->plays[joint];
    }
  };
  std::vector<std::size_t> held;  // by each segment
  if (delay_ > 0.0) {
    hold(time.front(), mapped(0.0));
    held.push_back(time.size());
  }
  const bool rubs_by_load = std::ranges::any_of(effects, [&](const Effect& effect) {
    return effect.joint == joint && effect.form.roles().feels_load && effect.form.roles().dry_friction;
  });
  const bool spreads = fine != nullptr && rubs_by_load && lag_ == 0.0;
  std::vector<double> values(time.size());
  if (fine == nullptr || (effects_.empty() && !spreads)) {
    for (std::size_t k = 0; k < time.size(); ++k) {
      reach(k);
      values[k] = mapped(input[k]);
    }
  } else {
    const auto samples = static_cast<Eigen::Index>(time.size());
    const auto rows = std::ranges::lower_bound(fine->stays, samples) - fine->stays.begin();
    Eigen::VectorXd all = fine->input.col(joint).head(rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      reach(static_cast<std::size_t>(fine->stays[static_cast<std::size_t>(k)]));
      all[k] = mapped(all[k]);
    }
    if (spreads) spread_ = InputSpread(*fine, all, samples);
    const Eigen::VectorXd sums = fine->held(all, samples);
    values.assign(sums.begin(), sums.end());
  }
  for (std::size_t k = 0; k < time.size(); ++k) {
    const bool pauses = k > 0 && delay_ > 0.0 && time[k - 1] + delay_ < time[k];
    if (pauses && std::ranges::binary_search(restarts, k, {}, &Restart::sample)) {
      hold(time[k], values[k]);
      held.push_back(k);
    }
    hold(time[k] + delay_, values[k]);
    held.push_back(k);
  }
  if (spreads) held_sample_ = std::move(held);
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
