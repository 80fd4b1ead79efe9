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
constexpr double kShortestStep = 3e-4;  // s
constexpr double kSettled = 1e-4;       // of the velocity, by which a hidden state still moves
constexpr int kMostStops = 16;          // within one step; beyond that joints that stand rest until its end

int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

JointSlots padded(const JointVector& values) {
  JointSlots slots = JointSlots::Zero();
  for (Eigen::Index j = 0; j < values.size(); ++j) slots[j] = values[j];
  return slots;
}

/// What torques add to accelerations.
JointSlots moved_by(const JointMatrix& mobility, const JointSlots& torque) {
  JointSlots result = JointSlots::Zero();
  for (Eigen::Index i = 0; i < mobility.rows(); ++i) {
    for (Eigen::Index j = 0; j < mobility.cols(); ++j) result[i] += mobility(i, j) * torque[j];
  }
  return result;
}

}  // namespace

/// [q, v], and one hidden state per joint (presliding).
struct Machine::State {
  JointSlots q, v, z;
};

/// Where in time and in which regime the machine is: direction of sliding (0: stuck) of each joint with dry friction,
/// and the segment of each drive.
struct Machine::Moment {
  double t = 0.0;
  const std::vector<Drive>* drives = nullptr;
  std::array<std::size_t, kMaxJoints> segment{};
  std::array<int, kMaxJoints> direction{};
  Remainder::Memory memory;
};

Machine::Machine(const Plant& plant, std::vector<Effect> effects, Remainder remainder)
    : plant_(plant),
      effects_(std::move(effects)),
      remainder_(std::move(remainder)),
      remainder_sum_(remainder_),
      joints_(bayesctrl::joints(plant_)),
      added_inertia_(JointVector::Zero(joints_)),
      tilt_(JointVector::Zero(joints_)) {
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (DryFriction<E>) dry_[static_cast<std::size_t>(effect.joint)] = true;
          if constexpr (InertiaEffect<E>) added_inertia_[effect.joint] += form.added_inertia();
          if constexpr (TiltEffect<E>) tilt_[effect.joint] += form.tilt();
          if constexpr (HiddenStateEffect<E>) has_hidden_states_ = true;
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

/// Inputs of all joints at time t.
JointVector Machine::input_at(const Moment& moment, double t) const {
  JointVector input(joints_);
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    input[j] = (*moment.drives)[slot].at(moment.segment[slot], t);
  }
  return input;
}

/// q'' at one state. Joints that are stuck do not accelerate; the torques that hold them go to `holding_torque`.
JointSlots Machine::acceleration(const State& state, const Moment& moment, double t, JointSlots* holding_torque) const {
  const JointVector q = state.q.head(joints_), v = state.v.head(joints_), input = input_at(moment, t);
  const Motion nominal = motion(plant_, q, v, input, t);
  JointSlots external = JointSlots::Zero(), torque = external, motor = external;
  if (needs_external_torque_) {
    external = padded(external_torque(plant_, q));
    if (!tilt_.isZero()) torque = padded(external_torque(plant_, q + tilt_)) - external;
    motor = padded(motor_torque(q, v, input, t));
  } else {
    motor = padded(input);
  }

  if (!remainder_sum_.empty()) torque += padded(remainder_sum_.torque(moment.memory, q, v, input, t));
  JointSlots friction = JointSlots::Zero();
  for (const Effect& effect : effects_) {
    const int j = effect.joint;
    const JointState seen{q[j], v[j], t, motor[j], external[j], q[neighbour_of(j, joints_)]};
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

  // (M + D) q'' = M nominal + torques, D the added inertia and M^-1 the mobility: q'' = (1 + M^-1 D)^-1 (...).
  JointMatrix mobility = nominal.mobility;
  JointSlots result = padded(nominal.acceleration) + moved_by(mobility, torque);
  if (joints_ == 1) {
    const double scale = 1.0 / (1.0 + mobility(0, 0) * added_inertia_[0]);
    mobility(0, 0) *= scale;
    result[0] *= scale;
  } else if (added_inertia_.any()) {
    const JointMatrix system = JointMatrix::Identity(joints_, joints_) + mobility * added_inertia_.asDiagonal();
    const auto factor = system.partialPivLu();
    mobility = factor.solve(mobility).eval();
    result = padded(factor.solve(result.head(joints_)));
  }

  // The torques f that keep the stuck joints S at rest: mobility_SS f_S = -q''_S.
  JointSlots held = JointSlots::Zero();
  std::array<int, kMaxJoints> stuck{};
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
    result += moved_by(mobility, held);
    for (int a = 0; a < count; ++a) result[stuck[static_cast<std::size_t>(a)]] = 0.0;
  }
  if (holding_torque != nullptr) *holding_torque = held;
  return result;
}

/// Torque of the motors: the input itself, or for a custom machine what it adds to M q''.
JointVector Machine::motor_torque(const JointVector& q, const JointVector& v, const JointVector& input,
                                  double t) const {
  if (!std::holds_alternative<Custom>(plant_)) return input;
  const Motion driven = motion(plant_, q, v, input, t);
  const Motion idle = motion(plant_, q, v, JointVector::Zero(joints_), t);
  return driven.mobility.partialPivLu().solve(driven.acceleration - idle.acceleration);
}

double Machine::holding(const State& state, const Moment& moment, int joint) const {
  double external = 0.0, motor = 0.0;
  if (needs_external_torque_) {
    const JointVector q = state.q.head(joints_), v = state.v.head(joints_);
    external = external_torque(plant_, q)[joint];
    motor = motor_torque(q, v, input_at(moment, moment.t), moment.t)[joint];
  }
  const JointState seen{state.q[joint], 0.0, moment.t, motor, external, state.q[neighbour_of(joint, joints_)]};
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

/// Longest step that resolves hidden states, and lags after a switch of the input. Hidden states that have settled need
/// none while the joint goes on in the same direction.
double Machine::fine_step(const State& state, const Moment& moment, bool goes_on) const {
  double limit = kInfinity;
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const Drive& drive = (*moment.drives)[slot];
    const double since = moment.t - drive.switches()[moment.segment[slot]];
    if (drive.lag() > 0.0 && since < 8.0 * drive.lag()) limit = std::min(limit, 0.5 * drive.lag());
  }
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
Machine::State Machine::step(const State& state, const Moment& moment, double h) const {
  // Hidden states follow z' = rate(v, z), linear in z, exactly for a velocity that is constant within the step.
  const auto settled = [&](const JointSlots& v, double by) {
    JointSlots z = state.z;
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
  const auto moved = [&](const JointSlots& dq, const JointSlots& dv, const JointSlots& z, double by) {
    return State{state.q + by * dq, state.v + by * dv, z};
  };
  const double t = moment.t;
  const JointSlots a1 = acceleration(state, moment, t, nullptr);
  const State s2 = moved(state.v, a1, settled(state.v, 0.5 * h), 0.5 * h);
  const JointSlots a2 = acceleration(s2, moment, t + 0.5 * h, nullptr);
  const State s3 = moved(s2.v, a2, settled(s2.v, 0.5 * h), 0.5 * h);
  const JointSlots a3 = acceleration(s3, moment, t + 0.5 * h, nullptr);
  const State s4 = moved(s3.v, a3, settled(s3.v, h), h);
  const JointSlots a4 = acceleration(s4, moment, t + h, nullptr);
  const JointSlots mean = (state.v + 2.0 * s2.v + 2.0 * s3.v + s4.v) / 6.0;
  return moved(mean, (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0, settled(mean, h), h);
}

/// Decides for each joint that stands still whether friction holds it, else in which direction it breaks away.
void Machine::settle(State& state, Moment& moment) const {
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    if (!dry_[slot]) continue;
    if (std::abs(state.v[j]) <= kStopped) state.v[j] = 0.0;
    moment.direction[slot] = sign_of(state.v[j]);
  }
  const auto standing = [&](int j) {
    const auto slot = static_cast<std::size_t>(j);
    return dry_[slot] && moment.direction[slot] == 0;
  };
  for (int round = 0; round < joints_; ++round) {
    bool any = false;
    for (int j = 0; j < joints_; ++j) any |= standing(j);
    if (!any) return;
    JointSlots held;
    acceleration(state, moment, moment.t, &held);
    int worst = -1;
    double excess = 0.0;
    for (int j = 0; j < joints_; ++j) {
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
void Machine::advance(State& state, Moment& moment, double end, double max_step) const {
  int stops = 0;
  settle(state, moment);
  while (end - moment.t > 1e-12 * (1.0 + std::abs(end))) {
    const double left = end - moment.t;
    double h = left / std::ceil(left / std::min(max_step, fine_step(state, moment, true)));
    State next = step(state, moment, h);
    if (has_hidden_states_ && (next.v.array() * state.v.array() <= 0.0).head(joints_).any()) {
      h = left / std::ceil(left / std::min(max_step, fine_step(state, moment, false)));
      next = step(state, moment, h);
    }

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
    if (++stops > kMostStops) {  // joints that set one another free without end
      for (int j = 0; j < joints_; ++j) {
        if (state.v[j] == 0.0) moment.direction[static_cast<std::size_t>(j)] = 0;
      }
    }
  }
  moment.t = end;
}

/// From moment.t to `goal`, across switches of the drives and timed effects.
void Machine::advance_to(State& state, Moment& moment, double goal, double max_step) const {
  const auto catch_up = [&] {
    for (int j = 0; j < joints_; ++j) {
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
    for (int j = 0; j < joints_; ++j) {
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
  if (remainder_.empty()) return advance_to(state, moment, goal, max_step);
  const JointVector input = input_at(moment, moment.t);
  if (moment.memory.empty()) {
    moment.memory = remainder_.begin(state.q.head(joints_), state.v.head(joints_), input);
  }
  const double since = moment.t;
  const State before = state;
  advance_to(state, moment, goal, max_step);
  const JointSlots q = 0.5 * (before.q + state.q), v = 0.5 * (before.v + state.v);
  remainder_sum_.advance(moment.memory, q.head(joints_), v.head(joints_), input, goal - since);
}

Eigen::MatrixXd Machine::run(const StateVector& start, const std::vector<double>& time,
                             const std::vector<Drive>& drives, std::size_t first, std::size_t last, double max_step,
                             const JointVector& hidden, Eigen::MatrixXd* states,
                             const Remainder::Memory& memory) const {
  State state{padded(start.head(joints_)), padded(start.tail(joints_)), padded(hidden)};
  Moment moment;
  moment.t = time[first];
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

Eigen::MatrixXd Machine::hidden_states(const std::vector<double>& time, const Eigen::MatrixXd& velocity,
                                       const std::map<std::size_t, JointVector>& known) const {
  Eigen::MatrixXd z = Eigen::MatrixXd::Zero(velocity.rows(), joints_);
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (HiddenStateEffect<E>) {
            const int j = effect.joint;
            constexpr int kParts = 8;
            for (Eigen::Index k = 0; k + 1 < velocity.rows(); ++k) {
              const double h = (time[static_cast<std::size_t>(k) + 1] - time[static_cast<std::size_t>(k)]) / kParts;
              double at = z(k, j);
              for (int i = 0; i < kParts; ++i) {
                const double s = (i + 0.5) / kParts, v = (1.0 - s) * velocity(k, j) + s * velocity(k + 1, j);
                const double decay = form.settling_rate(v) * h;
                at += form.rate(v, at) * (decay < 1e-6 ? h : h * -std::expm1(-decay) / decay);
              }
              const auto given = known.find(static_cast<std::size_t>(k) + 1);
              z(k + 1, j) = given == known.end() ? at : given->second[j];
            }
          }
        },
        effect.form);
  }
  return z;
}

struct Simulation::Now {
  Machine::State state;
  Machine::Moment moment;
  std::vector<Drive> drives;
};

Simulation::Simulation(const Machine& machine, const StateVector& start, double time, double max_step)
    : machine_(machine), max_step_(max_step), now_(std::make_unique<Now>()) {
  const int n = machine.joints();
  now_->state = {padded(start.head(n)), padded(start.tail(n)), JointSlots::Zero()};
  now_->moment.t = time;
  for (int j = 0; j < n; ++j) now_->drives.emplace_back(machine.effects(), j);
  now_->moment.drives = &now_->drives;
}

Simulation::~Simulation() = default;

void Simulation::hold(const JointVector& input) {
  for (std::size_t j = 0; j < now_->drives.size(); ++j) {
    now_->drives[j].append(now_->moment.t, input[static_cast<Eigen::Index>(j)]);
  }
}

void Simulation::advance(double time) {
  machine_.advance_and_remember(now_->state, now_->moment, time, max_step_);
  if (!now_->state.q.allFinite() || !now_->state.v.allFinite()) {
    throw NumericalError("the model diverges at t = " + format(now_->moment.t, 6) + " s");
  }
}

StateVector Simulation::state() const {
  const int n = machine_.joints();
  StateVector x(2 * n);
  x << now_->state.q.head(n), now_->state.v.head(n);
  return x;
}

}  // namespace bayesctrl
