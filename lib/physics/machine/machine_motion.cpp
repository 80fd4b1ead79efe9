// How a machine moves: steps of the integration, cut where joints stop and inputs switch.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "base/error.hpp"
#include "base/format.hpp"
#include "physics/machine/machine_forces.hpp"

namespace bayesctrl {

namespace {

constexpr int kStopIterations = 30;     // of the search for the instant at which a joint stops
constexpr double kStopped = 1e-13;      // rad/s: below this a joint stands; rad: so near it touches
constexpr double kShortestStep = 3e-4;  // s
constexpr int kMostStops = 16;          // within one step; beyond that joints that stand rest until its end
constexpr int kMostTouches = 64;        // that are found exactly, likewise; beyond that a step may go across one
constexpr double kContactPart = 0.125;  // of the time in which a contact swings or settles: a step within it
constexpr double kContactSteps = 50.0;  // of the longest step: a contact asks for no shorter one

int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

}  // namespace

/// Longest step that resolves hidden states. Those that are steady need none while the joint goes on in the same
/// direction.
template <int kJoints>
double Machine::fine_step(const StateOf<kJoints>& state, const Moment& moment, bool goes_on) const {
  double limit = kInfinity;
  if (hidden_count_ == 0) return limit;
  Load<kJoints> on_bearings;
  if (load_drives_hidden_) {
    on_bearings = load_on_hidden<kJoints>(state, input_at<kJoints>(moment, moment.t), moment.t);
  }
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const EffectForm& form = effects_[e].form;
    if (!form.roles().hidden_state) continue;
    JointState here = seen<kJoints>(effects_[e].joint, state, moment.t, on_bearings);
    if (form.roles().swings) {
      const Joints<kJoints> input = input_at<kJoints>(moment, moment.t);
      here.mobility =
          motion_of<kJoints>(plant_, state.q, state.v, input, moment.t).mobility(effects_[e].joint, effects_[e].joint);
    }
    if (goes_on && form.is_steady(part_of(state.z, form, slots_[e]), here)) continue;
    limit = std::min(limit, 0.5 / std::max(1e-9, form.settling_rate(here)));
  }
  return std::max(limit, kShortestStep);
}

/// Longest step that resolves the contacts in which joints are, and that ends where another begins.
template <int kJoints>
double Machine::contact_step(const StateOf<kJoints>& state, const Moment& moment, double max_step) const {
  const double shortest = max_step / kContactSteps;
  double limit = kInfinity;
  for (const std::size_t e : contacts_) {
    const int j = effects_[e].joint;
    const double depth = effects_[e].form.depth(state.q[j]);
    if (depth < 0.0) {
      const double inwards = effects_[e].form.depth(state.q[j] + state.v[j]) - depth;  // of a second
      if (inwards > 0.0) limit = std::min(limit, std::max(-depth / inwards, shortest));
      continue;
    }
    const auto here = motion_of<kJoints>(plant_, state.q, state.v, input_at<kJoints>(moment, moment.t), moment.t);
    const double step = kContactPart / effects_[e].form.contact_rate(here.mobility(j, j));
    if (step < shortest) {
      throw NumericalError(std::string(effects_[e].form.name()) + " in joint " + std::to_string(j + 1) +
                           " is stiffer than can be followed: it asks for steps of " + format(step, 2) +
                           " s, and none is shorter than " + format(shortest, 2) + " s");
    }
    limit = std::min(limit, step);
  }
  return limit;
}

/// One Runge-Kutta step of length h in the present regime.
template <int kJoints>
Machine::StateOf<kJoints> Machine::step(const StateOf<kJoints>& state, const Moment& moment, double h) const {
  const double t = moment.t, half = t + 0.5 * h;
  const InputOver<kJoints> u = input_over<kJoints>(moment, h);
  const Joints<kJoints> first = u.middle - u.half_rise, last = u.middle + u.half_rise;
  HiddenVector k1(hidden_count_), k2(hidden_count_), k3(hidden_count_), k4(hidden_count_);
  // Hidden states that can say how they settle follow the velocities of the stages.
  const auto moved = [&](const StateOf<kJoints>& at, const Joints<kJoints>& input, double when,
                         const Joints<kJoints>& dv, double by, HiddenVector& rates) {
    return StateOf<kJoints>{state.q + by * at.v, state.v + by * dv,
                            follow<kJoints>(state.z, at, input, when, by, &rates)};
  };
  const Joints<kJoints> a1 = acceleration<kJoints>(state, first, moment, t, nullptr);
  const StateOf<kJoints> s2 = moved(state, first, t, a1, 0.5 * h, k1);
  const Joints<kJoints> a2 = acceleration<kJoints>(s2, u.middle, moment, half, nullptr);
  const StateOf<kJoints> s3 = moved(s2, u.middle, half, a2, 0.5 * h, k2);
  const Joints<kJoints> a3 = acceleration<kJoints>(s3, u.middle, moment, half, nullptr);
  const StateOf<kJoints> s4 = moved(s3, u.middle, half, a3, h, k3);
  const Joints<kJoints> a4 = acceleration<kJoints>(s4, last, moment, t + h, nullptr);
  const Joints<kJoints> v = (state.v + 2.0 * s2.v + 2.0 * s3.v + s4.v) / 6.0;
  const Joints<kJoints> a = (a1 + 2.0 * a2 + 2.0 * a3 + a4) / 6.0;
  StateOf<kJoints> next{state.q + h * v, state.v + h * a, {}};
  if (hidden_count_ > 0) {
    if (!hidden_settle_) {
      follow<kJoints>(state.z, s4, last, t + h, h, &k4);
      k1 = (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
    }
    const StateOf<kJoints> mean{(state.q + 2.0 * s2.q + 2.0 * s3.q + s4.q) / 6.0, v, {}};
    next.z = follow<kJoints>(state.z, mean, u.middle, half, h, &k1);
  }
  return next;
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
  int stops = 0, touches = 0;
  const auto touch = [&] {
    moment.touched.resize(contacts_.empty() ? 0 : effects_.size());
    for (const std::size_t e : contacts_) {
      moment.touched[e] = effects_[e].form.depth(state.q[effects_[e].joint]) >= 0.0;
    }
  };
  touch();
  settle(state, moment);
  while (end - moment.t > 1e-12 * (1.0 + std::abs(end))) {
    touch();
    const double left = end - moment.t;
    const double most = std::min(max_step, contact_step(state, moment, max_step));
    double h = left / std::ceil(left / std::min(most, fine_step(state, moment, true)));
    StateOf<kJoints> next = step(state, moment, h);
    if (hidden_count_ > 0 && (next.v.array() * state.v.array() <= 0.0).any()) {
      h = left / std::ceil(left / std::min(most, fine_step(state, moment, false)));
      next = step(state, moment, h);
    }

    int stopping = -1;
    const EffectForm* contact = nullptr;
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
    int touching = -1;
    for (const std::size_t e : contacts_) {
      const int j = effects_[e].joint;
      const double from = effects_[e].form.depth(state.q[j]), to = effects_[e].form.depth(next.q[j]);
      if (from * to >= 0.0 || touches > kMostTouches) continue;
      const double guess = from / (from - to);
      if (guess < fraction) {
        fraction = guess;
        contact = &effects_[e].form;
        touching = j;
      }
    }
    if (stopping < 0 && contact == nullptr) {
      state = next;
      moment.t += h;
      continue;
    }

    // The instant at which that happens, by the Illinois variant of the false position.
    const double begins = contact == nullptr ? moment.direction[static_cast<std::size_t>(stopping)]
                          : contact->depth(state.q[touching]) > 0.0 ? 1.0
                                                                    : -1.0;
    const auto ahead = [&](const StateOf<kJoints>& at) {  // positive until then
      return begins * (contact == nullptr ? at.v[stopping] : contact->depth(at.q[touching]));
    };
    double low = 0.0, high = h, at_low = ahead(state), at_high = ahead(next);
    double instant = fraction * h;
    StateOf<kJoints> stopped = state;
    for (int i = 0; i < kStopIterations && high - low > 1e-14 * h; ++i) {
      instant = at_low > at_high ? std::clamp(low + (high - low) * at_low / (at_low - at_high), low, high) : low;
      stopped = step(state, moment, instant);
      const double value = ahead(stopped);
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
    moment.t += instant;
    if (contact != nullptr) {  // on the other side, by as little as counts
      const double q = state.q[touching], depth = contact->depth(q);
      const double beyond = std::max(kStopped, 1e-15 * std::abs(q));
      state.q[touching] += (-begins * beyond - depth) * (contact->depth(q + 1.0) > depth ? 1.0 : -1.0);
      ++touches;
      continue;
    }
    state.v[stopping] = 0.0;
    settle(state, moment);
    if (++stops > kMostStops) {  // joints that set one another free without end
      for (int j = 0; j < kJoints; ++j) {
        if (state.v[j] == 0.0) moment.direction[static_cast<std::size_t>(j)] = 0;
      }
    }
  }
  moment.t = end;
}

/// The segments of the drives at moment.t.
template <int kJoints>
void Machine::catch_up(Moment& moment) const {
  for (int j = 0; j < kJoints; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const std::vector<double>& switches = (*moment.drives)[slot].switches();
    while (moment.segment[slot] + 1 < switches.size() && switches[moment.segment[slot] + 1] <= moment.t) {
      ++moment.segment[slot];
    }
  }
}

/// From moment.t to `goal`, across switches of the drives and timed effects.
template <int kJoints>
void Machine::advance_to(StateOf<kJoints>& state, Moment& moment, double goal, double max_step) const {
  catch_up<kJoints>(moment);
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
    catch_up<kJoints>(moment);
  }
}

/// The same; the remainder then remembers what has happened in between.
void Machine::advance_and_remember(State& state, Moment& moment, double goal, double max_step) const {
  with_joints(plant_, [&]<int kJoints>(const auto& /*plant*/, std::integral_constant<int, kJoints>) {
    StateOf<kJoints> now{state.q.head<kJoints>(), state.v.head<kJoints>(), state.z};
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
    state.z = now.z;
  });
}

/// The segments of the drives at moment.t, wherever they were.
void Machine::locate(Moment& moment) const {
  for (int j = 0; j < joints_; ++j) {
    const auto slot = static_cast<std::size_t>(j);
    const std::vector<double>& switches = (*moment.drives)[slot].switches();
    const auto after = std::upper_bound(switches.begin(), switches.end(), moment.t);
    moment.segment[slot] = static_cast<std::size_t>(after - switches.begin()) - 1;
  }
}

HiddenStates Machine::hidden_after(HiddenStates begin, const std::vector<double>& time, const Eigen::MatrixXd& position,
                                   const Eigen::MatrixXd& velocity, const std::vector<Drive>& drives, std::size_t from,
                                   std::size_t to) const {
  for (int j = 0; j < joints_; ++j) {
    begin.lags[j] = lag_[j] > 0.0 ? begin.lags[j] * std::exp(-(time[to] - time[from]) / lag_[j]) : 0.0;
  }
  if (hidden_count_ == 0) return begin;
  if (begin.effects.size() == 0) begin.effects = HiddenVector::Zero(hidden_count_);
  constexpr double kPart = 2.5e-3;  // s, of the time between two samples,
  constexpr double kParts = 8.0;    // in no more of them
  const JointVector none = measured(JointVector::Zero(joints_)), scale = measured_scale();
  with_joints(plant_, [&]<int kJoints>(const auto& /*plant*/, std::integral_constant<int, kJoints>) {
    Moment moment;
    moment.t = time[from];
    moment.drives = &drives;
    locate(moment);
    StateOf<kJoints> now{{}, {}, begin.effects};
    for (std::size_t k = from; k < to; ++k) {
      const auto row = static_cast<Eigen::Index>(k);
      const double parts = std::clamp(std::ceil((time[k + 1] - time[k]) / kPart), 1.0, kParts);
      for (int i = 0; i < parts; ++i) {
        const double s = (i + 0.5) / parts;
        const JointVector q = (1.0 - s) * position.row(row).transpose() + s * position.row(row + 1).transpose();
        const JointVector v = (1.0 - s) * velocity.row(row).transpose() + s * velocity.row(row + 1).transpose();
        now.q = (q - none).cwiseQuotient(scale);
        now.v = v.cwiseQuotient(scale);
        moment.t = (1.0 - s) * time[k] + s * time[k + 1];
        catch_up<kJoints>(moment);
        settle_along<kJoints>(now, input_at<kJoints>(moment, moment.t), moment.t, (time[k + 1] - time[k]) / parts);
      }
    }
    begin.effects = now.z;
  });
  return begin;
}

Eigen::MatrixXd Machine::run(const StateVector& start, const std::vector<double>& time,
                             const std::vector<Drive>& drives, std::size_t first, std::size_t last, double max_step,
                             const HiddenStates& hidden, Eigen::MatrixXd* states,
                             const Remainder::Memory& memory) const {
  if (hidden.effects.size() > 0 && hidden.effects.size() != hidden_count_) {
    throw std::invalid_argument("hidden states do not fit the machine's effects");
  }
  State state{padded(start.head(joints_)), padded(start.tail(joints_)), HiddenVector::Zero(hidden_count_)};
  if (hidden.effects.size() > 0) state.z = hidden.effects;
  Moment moment;
  moment.t = moment.begin = time[first];
  for (int j = 0; j < joints_; ++j) moment.departure[j] = lag_[j] > 0.0 ? hidden.lags[j] : 0.0;
  moment.drives = &drives;
  moment.memory = memory;
  locate(moment);
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
