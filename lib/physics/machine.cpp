#include "physics/machine.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/format.hpp"

namespace bayesctrl {

namespace {

constexpr int kStopIterations = 30;     // of the search for the instant at which a joint stops
constexpr double kStopped = 1e-13;      // rad/s: below this a joint stands
constexpr double kShortestStep = 1e-6;  // s
constexpr int kMostStops = 16;          // within one step; beyond that the joint is taken to rest

int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

}  // namespace

/// [q, v], and one hidden state per joint (presliding).
struct Machine::State {
  JointVector q, v, z;
};

/// Where in time and in which regime the machine is: direction of sliding (0: stuck) of each joint with dry friction,
/// and the segment of each drive.
struct Machine::Moment {
  double t = 0.0;
  const std::vector<Drive>* drives = nullptr;
  std::array<std::size_t, kSlots> segment{};
  std::array<int, kSlots> direction{};
};

Machine::Machine(const Plant& plant, std::vector<Effect> effects)
    : plant_(std::move(plant)),
      effects_(std::move(effects)),
      joints_(bayesctrl::joints(plant_)),
      added_inertia_(JointVector::Zero(joints_)),
      tilt_(JointVector::Zero(joints_)) {
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (DryFriction<E>) dry_[static_cast<std::size_t>(effect.joint)] = true;
          if constexpr (InertiaEffect<E>) added_inertia_[effect.joint] += form.added_inertia();
          if constexpr (TiltEffect<E>) tilt_[effect.joint] += form.tilt();
          if constexpr (TimedEffect<E>) switch_times_.push_back(form.switch_time());
          if constexpr (TiltEffect<E> || std::is_same_v<E, LoadDependentFriction>) needs_external_torque_ = true;
        },
        effect.form);
  }
  std::sort(switch_times_.begin(), switch_times_.end());
}

std::vector<Drive> Machine::drives(const std::vector<double>& time, const Eigen::MatrixXd& input) const {
  std::vector<Drive> list;
  for (int j = 0; j < joints_; ++j) {
    list.emplace_back(time, std::vector<double>(input.col(j).begin(), input.col(j).end()), effects_, j);
  }
  return list;
}

JointVector Machine::measured(const JointVector& position) const {
  JointVector shown = position;
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (SensorEffect<E>) shown[effect.joint] = form.measured(shown[effect.joint]);
        },
        effect.form);
  }
  return shown;
}

/// q'' at one state. Joints that are stuck do not accelerate; the torques that hold them go to `holding_torque`.
JointVector Machine::acceleration(const State& state, const Moment& moment, double t,
                                  JointVector* holding_torque) const {
  const Affine nominal = affine(plant_, state.q, state.v);
  JointVector external = JointVector::Zero(joints_), tilted = JointVector::Zero(joints_);
  if (needs_external_torque_) {
    const JointVector rest = JointVector::Zero(joints_);
    const auto torque_at = [&](const JointVector& q) -> JointVector {
      const Affine still = affine(plant_, q, rest);
      return still.gain.partialPivLu().solve(still.drift);
    };
    external = torque_at(state.q);
    tilted = torque_at(state.q + tilt_);
  }

  JointVector torque = tilted - external;
  JointVector friction = JointVector::Zero(joints_);
  JointVector motor(joints_);
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    motor[j] = (*moment.drives)[slot].at(moment.segment[slot], t);
  }
  for (const Effect& effect : effects_) {
    const int j = effect.joint;
    const JointState seen{state.q[j], state.v[j], t, motor[j], external[j]};
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (TimedEffect<E>) {  // steps end at its switch: what holds at their beginning holds throughout
            torque[j] += form.torque_at({.time = moment.t});
          } else if constexpr (TorqueEffect<E>) {
            torque[j] += form.torque_at(seen);
          }
          if constexpr (DryFriction<E>) friction[j] += form.sliding(seen);
          if constexpr (HiddenStateEffect<E>) torque[j] += form.torque_of(state.z[j]);
        },
        effect.form);
  }
  for (int j = 0; j < joints_; ++j) torque[j] -= moment.direction[static_cast<std::size_t>(j)] * friction[j];

  // (M + D) q'' = M drift + torques, D the added inertia and M^-1 the plant's gain: q'' = (1 + M^-1 D)^-1 (...).
  JointMatrix mobility = nominal.gain;
  JointVector result = nominal.drift + nominal.gain * (motor + torque);
  if (joints_ == 1) {
    const double scale = 1.0 / (1.0 + nominal.gain(0, 0) * added_inertia_[0]);
    mobility *= scale;
    result *= scale;
  } else if (added_inertia_.any()) {
    const JointMatrix system = JointMatrix::Identity(joints_, joints_) + nominal.gain * added_inertia_.asDiagonal();
    const auto factor = system.partialPivLu();
    mobility = factor.solve(mobility).eval();
    result = factor.solve(result).eval();
  }

  // The torques f that keep the stuck joints S at rest: mobility_SS f_S = -q''_S.
  JointVector held = JointVector::Zero(joints_);
  std::array<int, kSlots> stuck{};
  int count = 0;
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    if (dry_[slot] && moment.direction[slot] == 0) stuck[static_cast<std::size_t>(count++)] = j;
  }
  if (count > 0) {
    JointMatrix system(count, count);
    JointVector wanted(count);
    for (int a = 0; a < count; ++a) {
      wanted[a] = -result[stuck[static_cast<std::size_t>(a)]];
      for (int b = 0; b < count; ++b) {
        system(a, b) = mobility(stuck[static_cast<std::size_t>(a)], stuck[static_cast<std::size_t>(b)]);
      }
    }
    const JointVector f =
        count == 1 ? JointVector(wanted / system(0, 0)) : JointVector(system.partialPivLu().solve(wanted));
    for (int a = 0; a < count; ++a) held[stuck[static_cast<std::size_t>(a)]] = f[a];
    result += mobility * held;
    for (int a = 0; a < count; ++a) result[stuck[static_cast<std::size_t>(a)]] = 0.0;
  }
  if (holding_torque != nullptr) *holding_torque = held;
  return result;
}

double Machine::holding(const State& state, const Moment& moment, int joint) const {
  double external = 0.0;
  if (needs_external_torque_) {
    const Affine still = affine(plant_, state.q, JointVector::Zero(joints_));
    external = JointVector(still.gain.partialPivLu().solve(still.drift))[joint];
  }
  const auto slot = static_cast<std::size_t>(joint);
  const double motor = (*moment.drives)[slot].at(moment.segment[slot], moment.t);
  const JointState seen{state.q[joint], 0.0, moment.t, motor, external};
  double level = 0.0;
  for (const Effect& effect : effects_) {
    if (effect.joint != joint) continue;
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (DryFriction<E>) level += form.holding(seen);
        },
        effect.form);
  }
  return level;
}

/// Longest step at which the hidden states are integrated stably.
double Machine::stable_step(const State& state) const {
  double limit = kInfinity;
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (HiddenStateEffect<E>) {
            limit = std::min(limit, 1.0 / std::max(1e-9, form.settling_rate(state.v[effect.joint])));
          }
        },
        effect.form);
  }
  return std::max(limit, kShortestStep);
}

/// One Runge-Kutta step of length h in the present regime.
Machine::State Machine::step(const State& state, const Moment& moment, double h) const {
  const auto rate = [&](const State& s) {
    JointVector zdot = JointVector::Zero(joints_);
    for (const Effect& effect : effects_) {
      std::visit(
          [&]<class E>(const E& form) {
            if constexpr (HiddenStateEffect<E>) zdot[effect.joint] = form.rate(s.v[effect.joint], s.z[effect.joint]);
          },
          effect.form);
    }
    return zdot;
  };
  const auto moved = [&](const JointVector& dq, const JointVector& dv, const JointVector& dz, double by) {
    return State{state.q + by * dq, state.v + by * dv, state.z + by * dz};
  };
  const double t = moment.t;
  const JointVector a1 = acceleration(state, moment, t, nullptr), z1 = rate(state);
  const State s2 = moved(state.v, a1, z1, 0.5 * h);
  const JointVector a2 = acceleration(s2, moment, t + 0.5 * h, nullptr), z2 = rate(s2);
  const State s3 = moved(s2.v, a2, z2, 0.5 * h);
  const JointVector a3 = acceleration(s3, moment, t + 0.5 * h, nullptr), z3 = rate(s3);
  const State s4 = moved(s3.v, a3, z3, h);
  const JointVector a4 = acceleration(s4, moment, t + h, nullptr), z4 = rate(s4);
  return moved((state.v + 2.0 * s2.v + 2.0 * s3.v + s4.v) / 6.0, (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0,
               (z1 + 2.0 * z2 + 2.0 * z3 + z4) / 6.0, h);
}

/// Decides for each joint that stands still whether friction holds it, else in which direction it breaks away.
void Machine::settle(State& state, Moment& moment) const {
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    if (!dry_[slot]) continue;
    if (std::abs(state.v[j]) <= kStopped) state.v[j] = 0.0;
    moment.direction[slot] = sign_of(state.v[j]);
  }
  for (int round = 0; round < joints_; ++round) {
    JointVector held;
    acceleration(state, moment, moment.t, &held);
    int worst = -1;
    double excess = 0.0;
    for (int j = 0; j < joints_; ++j) {
      const auto slot = static_cast<std::size_t>(j);
      if (!dry_[slot] || moment.direction[slot] != 0) continue;
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
void Machine::advance(State& state, Moment& moment, double end, double max_step) const {
  int stops = 0;
  settle(state, moment);
  while (end - moment.t > 1e-12 * (1.0 + std::abs(end))) {
    const double left = end - moment.t;
    const double h = left / std::ceil(left / std::min(max_step, stable_step(state)));
    State next = step(state, moment, h);

    int stopping = -1;
    double fraction = 1.0;
    for (int j = 0; j < joints_; ++j) {
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
    State stopped = state;
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
    if (++stops > kMostStops) moment.direction[static_cast<std::size_t>(stopping)] = 0;
  }
  moment.t = end;
}

Eigen::MatrixXd Machine::run(const StateVector& start, const std::vector<double>& time,
                             const std::vector<Drive>& drives, std::size_t first, std::size_t last,
                             double max_step) const {
  State state{start.head(joints_), start.tail(joints_), JointVector::Zero(joints_)};
  Moment moment;
  moment.t = time[first];
  moment.drives = &drives;
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const std::vector<double>& switches = drives[slot].switches();
    const auto after = std::upper_bound(switches.begin(), switches.end(), moment.t);
    moment.segment[slot] = static_cast<std::size_t>(after - switches.begin()) - 1;
  }
  Eigen::MatrixXd shown(static_cast<Eigen::Index>(last - first + 1), joints_);
  for (std::size_t k = first;; ++k) {
    shown.row(static_cast<Eigen::Index>(k - first)) = measured(state.q);
    if (!state.q.allFinite() || !state.v.allFinite()) {
      throw NumericalError("the model diverges at t = " + format(moment.t, 6) + " s");
    }
    if (k == last) return shown;
    while (moment.t < time[k + 1]) {
      double end = time[k + 1];
      for (int j = 0; j < joints_; ++j) {
        const auto slot = static_cast<std::size_t>(j);
        const std::vector<double>& switches = drives[slot].switches();
        if (moment.segment[slot] + 1 < switches.size()) end = std::min(end, switches[moment.segment[slot] + 1]);
      }
      const auto timed = std::upper_bound(switch_times_.begin(), switch_times_.end(), moment.t);
      if (timed != switch_times_.end()) end = std::min(end, *timed);
      if (end > moment.t) advance(state, moment, end, max_step);
      for (int j = 0; j < joints_; ++j) {
        const auto slot = static_cast<std::size_t>(j);
        const std::vector<double>& switches = drives[slot].switches();
        while (moment.segment[slot] + 1 < switches.size() && switches[moment.segment[slot] + 1] <= moment.t) {
          ++moment.segment[slot];
        }
      }
    }
  }
}

}  // namespace bayesctrl
