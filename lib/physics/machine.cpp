#include "physics/machine.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "physics/machine_state.hpp"

namespace bayesctrl {

namespace {

/// What torques add to accelerations.
JointSlots moved_by(const JointMatrix& mobility, const JointSlots& torque) {
  JointSlots result = JointSlots::Zero();
  for (Eigen::Index i = 0; i < mobility.rows(); ++i) {
    for (Eigen::Index j = 0; j < mobility.cols(); ++j) result[i] += mobility(i, j) * torque[j];
  }
  return result;
}

}  // namespace

Machine::Machine(const Plant& plant, std::vector<Effect> effects, Remainder remainder)
    : plant_(plant),
      effects_(std::move(effects)),
      remainder_(std::move(remainder)),
      remainder_sum_(remainder_),
      joints_(bayesctrl::joints(plant_)),
      added_inertia_(JointVector::Zero(joints_)),
      tilt_(JointVector::Zero(joints_)),
      lag_(JointVector::Zero(joints_)) {
  for (const Effect& effect : effects_) {
    std::visit(
        [&]<class E>(const E& form) {
          if constexpr (DryFriction<E>) dry_[static_cast<std::size_t>(effect.joint)] = true;
          if constexpr (InertiaEffect<E>) added_inertia_[effect.joint] += form.added_inertia();
          if constexpr (TiltEffect<E>) tilt_[effect.joint] += form.tilt();
          if constexpr (LagEffect<E>) lag_[effect.joint] = form.lag();
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
    if (moment.departure[j] != 0.0) input[j] += moment.departure[j] * std::exp(-(t - moment.begin) / lag_[j]);
  }
  return input;
}

/// q'' at one state. Joints that are stuck do not accelerate; the torques that hold them go to `holding_torque`.
JointSlots Machine::acceleration(const State& state, const Moment& moment, double t, JointSlots* holding_torque) const {
  const JointVector q = state.q.head(joints_), v = state.v.head(joints_), input = input_at(moment, t);
  const Motion nominal = motion(plant_, q, v, input, t);
  JointSlots external = JointSlots::Zero(), torque = external, motor = external;
  if (needs_external_torque_) {
    external = load_at(q);
    if (!tilt_.isZero()) torque = padded(external_torque(plant_, q + tilt_) - external_torque(plant_, q));
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

/// Torque of gravity, as the machine stands, and of springs.
JointSlots Machine::load_at(const JointVector& q) const {
  JointSlots load = padded(external_torque(plant_, q + tilt_));
  for (int j = 0; j < joints_; ++j) load[j] += spring_torque(effects_, j, q[j]);
  return load;
}

double Machine::holding(const State& state, const Moment& moment, int joint) const {
  double external = 0.0, motor = 0.0;
  if (needs_external_torque_) {
    const JointVector q = state.q.head(joints_), v = state.v.head(joints_);
    external = load_at(q)[joint];
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

JointVector Machine::decayed(const JointVector& lags, double by) const {
  JointVector left = JointVector::Zero(joints_);
  for (int j = 0; j < joints_; ++j) {
    if (lag_[j] > 0.0) left[j] = lags[j] * std::exp(-by / lag_[j]);
  }
  return left;
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

}  // namespace bayesctrl
