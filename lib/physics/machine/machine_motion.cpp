// How a machine moves: steps of the integration, cut where joints stop and inputs switch.

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"
#include "physics/machine/machine_forces.hpp"

namespace bayesctrl {

namespace {

constexpr int kStopIterations = 30;     // of the search for the instant at which a joint stops
constexpr double kStopped = 1e-13;      // rad/s: below this a joint stands
constexpr double kShortestStep = 3e-4;  // s
constexpr double kSettled = 1e-4;       // of the velocity, by which a hidden state still moves
constexpr int kMostStops = 16;          // within one step; beyond that joints that stand rest until its end

int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

}  // namespace

/// Longest step that resolves hidden states. Those that have settled need none while the joint goes on in the same
/// direction.
template <int kJoints>
double Machine::fine_step(const StateOf<kJoints>& state, bool goes_on) const {
  double limit = kInfinity;
  if (!has_hidden_states_) return limit;
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (HiddenStateEffect<E>) {
            const double v = state.v[effect.joint];
            if (goes_on && std::abs(form.rate(v, state.z[effect.joint])) < kSettled * std::abs(v)) return;
            limit = std::min(limit, 0.5 / std::max(1e-9, form.settling_rate(v)));
          }
        },
        effect.form);
  }
  return std::max(limit, kShortestStep);
}

/// One Runge-Kutta step of length h in the present regime.
template <int kJoints>
Machine::StateOf<kJoints> Machine::step(const StateOf<kJoints>& state, const Moment& moment, double h) const {
  // Hidden states follow z' = rate(v, z), linear in z, exactly for a velocity that is constant within the step.
  const auto settled = [&](const Joints<kJoints>& v, double by) {
    Joints<kJoints> z = state.z;
    if (!has_hidden_states_) return z;
    for (const Effect& effect : effects_) {
      std::visit(
          [&]<class E>(const E& form) {
            if constexpr (HiddenStateEffect<E>) {
              const double speed = v[effect.joint], decay = form.settling_rate(speed) * by;
              const double weight = decay < 1e-6 ? by : by * -std::expm1(-decay) / decay;
              z[effect.joint] += form.rate(speed, z[effect.joint]) * weight;
            }
          },
          effect.form);
    }
    return z;
  };
  const auto moved = [&](const Joints<kJoints>& dq, const Joints<kJoints>& dv, const Joints<kJoints>& z, double by) {
    return StateOf<kJoints>{state.q + by * dq, state.v + by * dv, z};
  };
  const double t = moment.t;
  const InputOver<kJoints> u = input_over<kJoints>(moment, h);
  const Joints<kJoints> a1 = acceleration<kJoints>(state, u.middle - u.half_rise, moment, t, nullptr);
  const StateOf<kJoints> s2 = moved(state.v, a1, settled(state.v, 0.5 * h), 0.5 * h);
  const Joints<kJoints> a2 = acceleration<kJoints>(s2, u.middle, moment, t + 0.5 * h, nullptr);
  const StateOf<kJoints> s3 = moved(s2.v, a2, settled(s2.v, 0.5 * h), 0.5 * h);
  const Joints<kJoints> a3 = acceleration<kJoints>(s3, u.middle, moment, t + 0.5 * h, nullptr);
  const StateOf<kJoints> s4 = moved(s3.v, a3, settled(s3.v, h), h);
  const Joints<kJoints> a4 = acceleration<kJoints>(s4, u.middle + u.half_rise, moment, t + h, nullptr);
  const Joints<kJoints> mean = (state.v + 2.0 * s2.v + 2.0 * s3.v + s4.v) / 6.0;
  return moved(mean, (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0, settled(mean, h), h);
}

/// Decides for each joint that stands still whether friction holds it, else in which direction it breaks away.
template <int kJoints>
void Machine::settle(StateOf<kJoints>& state, Moment& moment) const {
  for (int j = 0; j < kJoints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    if (!dry_[slot]) continue;
    if (std::abs(state.v[j]) <= kStopped) state.v[j] = 0.0;
    moment.direction[slot] = sign_of(state.v[j]);
  }
  const auto standing = [&](int j) {
    const auto slot = static_cast<std::size_t>(j);
    return dry_[slot] && moment.direction[slot] == 0;
  };
  for (int round = 0; round < kJoints; ++round) {
    bool any = false;
    for (int j = 0; j < kJoints; ++j) any |= standing(j);
    if (!any) return;
    Joints<kJoints> held;
    acceleration<kJoints>(state, input_at<kJoints>(moment, moment.t), moment, moment.t, &held);
    int worst = -1;
    double excess = 0.0;
    for (int j = 0; j < kJoints; ++j) {
      if (!standing(j)) continue;
      const double beyond = std::abs(held[j]) - holding(state, moment, j);
      if (beyond > excess) {
        excess = beyond;
        worst = j;
      }
    }
    if (worst < 0) return;
    moment.direction[static_cast<std::size_t>(worst)] = -sign_of(held[worst]);
  }
}

/// From moment.t to `end`, within which no drive switches.
template <int kJoints>
void Machine::advance(StateOf<kJoints>& state, Moment& moment, double end, double max_step) const {
  int stops = 0;
  settle(state, moment);
  while (end - moment.t > 1e-12 * (1.0 + std::abs(end))) {
    const double left = end - moment.t;
    double h = left / std::ceil(left / std::min(max_step, fine_step(state, true)));
    StateOf<kJoints> next = step(state, moment, h);
    if (has_hidden_states_ && (next.v.array() * state.v.array() <= 0.0).any()) {
      h = left / std::ceil(left / std::min(max_step, fine_step(state, false)));
      next = step(state, moment, h);
    }

    int stopping = -1;
    double fraction = 1.0;
    for (int j = 0; j < kJoints; ++j) {
      const auto slot = static_cast<std::size_t>(j);
      if (!dry_[slot] || moment.direction[slot] == 0 || next.v[j] * moment.direction[slot] >= 0.0) continue;
      const double guess = state.v[j] == next.v[j] ? 0.0 : state.v[j] / (state.v[j] - next.v[j]);
      if (guess < fraction) {
        fraction = guess;
        stopping = j;
      }
    }
    if (stopping < 0) {
      state = next;
      moment.t += h;
      continue;
    }

    // The instant at which the joint stops, by the Illinois variant of the false position.
    const int direction = moment.direction[static_cast<std::size_t>(stopping)];
    double low = 0.0, high = h, at_low = state.v[stopping] * direction, at_high = next.v[stopping] * direction;
    double instant = fraction * h;
    StateOf<kJoints> stopped = state;
    for (int i = 0; i < kStopIterations && high - low > 1e-14 * h; ++i) {
      instant = at_low > at_high ? std::clamp(low + (high - low) * at_low / (at_low - at_high), low, high) : low;
      stopped = step(state, moment, instant);
      const double value = stopped.v[stopping] * direction;
      if (std::abs(value) <= kStopped) break;
      if (value > 0.0) {
        low = instant;
        at_low = value;
        at_high *= 0.5;
      } else {
        high = instant;
        at_high = value;
        at_low *= 0.5;
      }
    }
    state = instant > 0.0 ? stopped : state;
    state.v[stopping] = 0.0;
    moment.t += instant;
    settle(state, moment);
    if (++stops > kMostStops) {  // joints that set one another free without end
      for (int j = 0; j < kJoints; ++j) {
        if (state.v[j] == 0.0) moment.direction[static_cast<std::size_t>(j)] = 0;
      }
    }
  }
  moment.t = end;
}

/// From moment.t to `goal`, across switches of the drives and timed effects.
template <int kJoints>
void Machine::advance_to(StateOf<kJoints>& state, Moment& moment, double goal, double max_step) const {
  const auto catch_up = [&] {
    for (int j = 0; j < kJoints; ++j) {
      const auto slot = static_cast<std::size_t>(j);
      const std::vector<double>& switches = (*moment.drives)[slot].switches();
      while (moment.segment[slot] + 1 < switches.size() && switches[moment.segment[slot] + 1] <= moment.t) {
        ++moment.segment[slot];
      }
    }
  };
  catch_up();
  while (moment.t < goal) {
    double end = goal;
    for (int j = 0; j < kJoints; ++j) {
      const auto slot = static_cast<std::size_t>(j);
      const std::vector<double>& switches = (*moment.drives)[slot].switches();
      if (moment.segment[slot] + 1 < switches.size()) end = std::min(end, switches[moment.segment[slot] + 1]);
    }
    const auto timed = std::upper_bound(switch_times_.begin(), switch_times_.end(), moment.t);
    if (timed != switch_times_.end()) end = std::min(end, *timed);
    if (end > moment.t) advance(state, moment, end, max_step);
    catch_up();
  }
}

/// The same; the remainder then remembers what has happened in between.
void Machine::advance_and_remember(State& state, Moment& moment, double goal, double max_step) const {
  with_joints(plant_, [&]<int kJoints>(const auto& /*plant*/, std::integral_constant<int, kJoints>) {
    StateOf<kJoints> now{state.q.head<kJoints>(), state.v.head<kJoints>(), state.z.head<kJoints>()};
    const StateOf<kJoints> before = now;
    const double since = moment.t;
    Joints<kJoints> input;
    if (!remainder_.empty()) {
      input = input_at<kJoints>(moment, moment.t);
      if (moment.memory.empty()) moment.memory = remainder_.begin(now.q, now.v);
    }
    advance_to(now, moment, goal, max_step);
    if (!remainder_.empty()) {
      const Joints<kJoints> q = 0.5 * (before.q + now.q), v = 0.5 * (before.v + now.v);
      remainder_sum_.advance(moment.memory, q, v, input, goal - since);
    }
    state.q.head<kJoints>() = now.q;
    state.v.head<kJoints>() = now.v;
    state.z.head<kJoints>() = now.z;
  });
}

Eigen::MatrixXd Machine::run(const StateVector& start, const std::vector<double>& time,
                             const std::vector<Drive>& drives, std::size_t first, std::size_t last, double max_step,
                             const HiddenStates& hidden, Eigen::MatrixXd* states,
                             const Remainder::Memory& memory) const {
  State state{padded(start.head(joints_)), padded(start.tail(joints_)), padded(hidden.effects)};
  Moment moment;
  moment.t = moment.begin = time[first];
  for (int j = 0; j < joints_; ++j) moment.departure[j] = lag_[j] > 0.0 ? hidden.lags[j] : 0.0;
  moment.drives = &drives;
  moment.memory = memory;
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const std::vector<double>& switches = drives[slot].switches();
    const auto after = std::upper_bound(switches.begin(), switches.end(), moment.t);
    moment.segment[slot] = static_cast<std::size_t>(after - switches.begin()) - 1;
  }
  Eigen::MatrixXd shown(static_cast<Eigen::Index>(last - first + 1), joints_);
  if (states != nullptr) states->resize(shown.rows(), 2 * joints_);
  for (std::size_t k = first;; ++k) {
    const auto row = static_cast<Eigen::Index>(k - first);
    shown.row(row) = measured(state.q.head(joints_));
    if (states != nullptr) {
      states->row(row) << state.q.head(joints_).transpose(), state.v.head(joints_).transpose();
    }
    if (!state.q.allFinite() || !state.v.allFinite()) {
      throw NumericalError("the model diverges at t = " + format(moment.t, 6) + " s");
    }
    if (k == last) return shown;
    advance_and_remember(state, moment, time[k + 1], max_step);
  }
}

}  // namespace bayesctrl
