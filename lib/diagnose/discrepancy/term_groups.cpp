#include "diagnose/discrepancy/term_groups.hpp"

#include <algorithm>
#include <utility>

#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

using Terms = std::vector<Term>;

/// Gaussian radial basis functions (RBF) of one quantity, a step wide and a step apart. `more`: their other parameters.
template <class B>
Terms rbfs(int joint, double low, double high, int count, auto... more) {
  const double step = std::max(high - low, 1e-9) / (count - 1);
  Terms list;
  for (int i = 0; i < count; ++i) list.push_back({B{low + i * step, step, more...}, joint});
  return list;
}

void append(Terms& list, const Terms& more) { list.insert(list.end(), more.begin(), more.end()); }

/// Between what the motion of one joint mostly is: a pendulum that turned over once has a wide range.
std::pair<double, double> most_of(const std::vector<Trajectory>& paths, Eigen::MatrixXd Trajectory::*of, int joint) {
  std::vector<double> all;
  for (const Trajectory& path : paths) {
    const Eigen::VectorXd values = (path.*of).col(joint);
    all.insert(all.end(), values.begin(), values.end());
  }
  std::sort(all.begin(), all.end());
  const auto at = [&](double part) {
    return all[static_cast<std::size_t>(part * static_cast<double>(all.size() - 1))];
  };
  return {at(kSettings.discrepancy.rare), at(1.0 - kSettings.discrepancy.rare)};
}

Terms velocity_terms(const OperatingRange& s, int joint) {
  Terms list = rbfs<RbfVelocity>(joint, -s.speed, s.speed, kSettings.discrepancy.rbfs);
  for (const double part : {0.005, 0.03, 0.15}) list.push_back({SignVelocity{part * s.speed}, joint});
  return list;
}

Terms input_terms(const OperatingRange& s, int joint) {
  Terms list = rbfs<RbfInput>(joint, -s.input, s.input, kSettings.discrepancy.rbfs);
  for (const double part : {0.01, 0.1}) list.push_back({SignInput{part * s.input}, joint});
  return list;
}

/// Centres that are `step` seconds apart, or further where they would be too many.
int times_in(double duration, double step, int least) {
  return std::max(least, static_cast<int>(std::min(duration / step, kSettings.discrepancy.most_times)));
}

/// Quick in what all recordings share, slow in each one alone.
Terms time_terms(const OperatingRange& s, int joint) {
  const double longest = *std::max_element(s.durations.begin(), s.durations.end());
  Terms list = rbfs<RbfTime>(joint, 0.0, longest, times_in(longest, kSettings.discrepancy.time_step, 4));
  for (std::size_t r = 0; r < s.durations.size(); ++r) {
    const int count = 1 + times_in(s.durations[r], kSettings.discrepancy.slow_time_step, 1);
    Terms slow = rbfs<RbfTime>(joint, 0.0, s.durations[r], count);
    for (Term& term : slow) term.recording = static_cast<int>(r);
    append(list, slow);
  }
  return list;
}

/// A gain or a drag that changes in time, alike in all recordings.
template <class B>
Terms changing_terms(const OperatingRange& s, int joint) {
  const double longest = *std::max_element(s.durations.begin(), s.durations.end());
  return rbfs<B>(joint, 0.0, longest, times_in(longest, kSettings.discrepancy.change_step, 4));
}

/// With several time constants. `more`: the other parameters.
template <class B>
Terms slow_terms(int joint, auto... more) {
  Terms list;
  for (const double tau : {0.03, 0.1, 0.3, 1.0, 3.0}) list.push_back({B{tau, more...}, joint});
  return list;
}

/// The same of what lags behind a quantity; beside it the quantity itself, so that the past may act alone.
template <Quantity kOf>
Terms late_terms(int joint) {
  Terms list = slow_terms<Late<kOf>>(joint);
  list.push_back({Power<kOf>{.exponent = 1.0, .odd = true}, joint});
  return list;
}

/// What the past leaves behind, each in one form.
std::vector<Terms> histories(const OperatingRange& s, int joint) {
  std::vector<Terms> list;
  if (s.input > 0.0) {
    list.push_back(late_terms<Quantity::input>(joint));
    list.push_back(slow_terms<WarmMotor>(joint));
  }
  list.push_back(late_terms<Quantity::velocity>(joint));
  list.push_back(late_terms<Quantity::position>(joint));
  list.push_back(slow_terms<WarmViscous>(joint));
  list.push_back(slow_terms<WarmDry>(joint, kSettings.discrepancy.slow * s.speed));
  list.push_back(slow_terms<Reversal>(joint, kSettings.discrepancy.slow * s.speed));
  Terms& plays = list.emplace_back();
  for (const double part : {0.005, 0.02, 0.06, 0.15, 0.3}) {
    plays.push_back({Play{part * (s.highest - s.lowest)}, joint});
  }
  return list;
}

/// Of one quantity, or of the position times something else: |x|^exponent, even and odd. `more`: other parameters.
template <class B>
Terms powers(int joint, std::initializer_list<std::pair<double, bool>> exponents, auto... more) {
  Terms list;
  for (const auto& [exponent, odd] : exponents) list.push_back({B{exponent, odd, more...}, joint});
  return list;
}

/// Linear from a threshold on, on either side.
template <class B>
Terms hinges(int joint, double most) {
  Terms list;
  for (const double part : {0.0, 0.05, 0.1, 0.2, 0.35, 0.55}) {
    list.push_back({B{-part * most, Side::below}, joint});
    list.push_back({B{part * most, Side::above}, joint});
  }
  return list;
}

Terms state_terms(const OperatingRange& s, int joint) {
  const double dq = (s.highest - s.lowest) / (kSettings.discrepancy.state_rbfs - 1),
               dv = 2.0 * s.speed / (kSettings.discrepancy.state_rbfs - 1);
  Terms list;
  for (int a = 0; a < kSettings.discrepancy.state_rbfs; ++a) {
    for (int b = 0; b < kSettings.discrepancy.state_rbfs; ++b) {
      list.push_back({RbfState{s.lowest + a * dq, dq, -s.speed + b * dv, dv}, joint});
    }
  }
  return list;
}

/// Low-passed functions of what was between -most and most.
template <class B>
Terms past_terms(int joint, double most) {
  Terms list;
  for (const double tau : {0.1, 0.3, 1.0})
    append(list, rbfs<B>(joint, -most, most, kSettings.discrepancy.past_rbfs, tau));
  return list;
}

/// The same of functions that saturate: few, and known beyond what was seen.
template <class B>
Terms late_sign_terms(int joint, double most) {
  Terms list;
  for (const double tau : {0.1, 0.3, 1.0}) {
    for (const double part : {0.1, 0.3, 1.0}) list.push_back({B{part * most, tau}, joint});
  }
  return list;
}

/// Whether the joint has come from above or from below: hysteresis.
Terms relay_terms(const OperatingRange& s, int joint) {
  const double range = s.highest - s.lowest, step = range / kSettings.discrepancy.relays;
  Terms list;
  for (const double part : {0.03, 0.08, 0.15, 0.25, 0.35}) {
    for (int i = 1; i < kSettings.discrepancy.relays; ++i) {
      list.push_back({Relay{.centre = s.lowest + i * step, .width = 0.25 * step, .half_gap = part * range}, joint});
    }
  }
  return list;
}

/// Masses on springs that the joint carries along, or that the input drives.
template <Quantity kOf>
Terms swing_terms(int joint) {
  Terms list;
  for (const auto& [damping, ratio] : {std::pair{0.04, 1.12}, {0.25, 1.5}}) {
    for (double frequency = kSettings.discrepancy.slowest_swing; frequency < kSettings.discrepancy.fastest_swing;
         frequency *= ratio) {
      list.push_back({Swing<kOf, PointerPart::real>{frequency, damping}, joint});
      list.push_back({Swing<kOf, PointerPart::imaginary>{frequency, damping}, joint});
    }
  }
  return list;
}

/// Input that follows at limited rates.
Terms slew_terms(const OperatingRange& s, int joint) {
  Terms list;
  for (const double rate : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0}) list.push_back({Slew{rate * s.input}, joint});
  return list;
}

}  // namespace

std::vector<TermGroup> term_groups(const OperatingRange& s, const std::vector<Trajectory>& paths, int joint) {
  std::vector<TermGroup> groups;
  const auto add = [&](Cause cause, TermUse use, Terms terms) {
    groups.push_back({cause, use, joint, std::move(terms)});
  };
  using enum TermUse;
  const bool driven = s.input > 0.0;
  add(Cause::position, compare, rbfs<RbfPosition>(joint, s.lowest, s.highest, kSettings.discrepancy.rbfs));
  add(Cause::velocity, compare, velocity_terms(s, joint));
  if (driven) add(Cause::input, compare, input_terms(s, joint));
  add(Cause::time, compare, time_terms(s, joint));
  const std::vector<Terms> forms = histories(s, joint);
  Terms history;
  for (const Terms& form : forms) append(history, form);
  add(Cause::history, compare, history);
  add(Cause::velocity, rich, state_terms(s, joint));
  add(Cause::velocity, rich, rbfs<PositionDrag>(joint, s.lowest, s.highest, kSettings.discrepancy.product_rbfs));
  add(Cause::velocity, rich,
      rbfs<PositionDry>(joint, s.lowest, s.highest, kSettings.discrepancy.product_rbfs,
                        kSettings.discrepancy.slow * s.speed));
  if (driven) {
    add(Cause::input, rich, rbfs<PositionGain>(joint, s.lowest, s.highest, kSettings.discrepancy.product_rbfs));
    add(Cause::input, rich, rbfs<VelocityGain>(joint, -s.speed, s.speed, kSettings.discrepancy.product_rbfs));
    add(Cause::input, rich, rbfs<RbfInput>(joint, -s.input, s.input, kSettings.discrepancy.fine_rbfs));
    add(Cause::time, rich, changing_terms<TimeGain>(s, joint));
    add(Cause::history, rich, past_terms<PastInput>(joint, s.input));
    add(Cause::history, rich, late_sign_terms<LatePush>(joint, s.input));
    add(Cause::history, rich, swing_terms<Quantity::input>(joint));
  }
  add(Cause::time, rich, changing_terms<TimeDrag>(s, joint));
  add(Cause::history, rich, past_terms<PastVelocity>(joint, s.speed));
  add(Cause::history, rich, late_sign_terms<LateDrag>(joint, s.speed));
  add(Cause::history, rich, relay_terms(s, joint));
  add(Cause::history, rich, swing_terms<Quantity::position>(joint));
  const auto [left, right] = most_of(paths, &Trajectory::position, joint);
  add(Cause::position, rich, rbfs<RbfPosition>(joint, left, right, kSettings.discrepancy.fine_rbfs));
  const auto [slowest, quickest] = most_of(paths, &Trajectory::velocity, joint);
  add(Cause::velocity, rich, rbfs<RbfVelocity>(joint, slowest, quickest, kSettings.discrepancy.fine_rbfs));

  for (const Terms& form : forms) add(Cause::history, parametric, form);
  add(Cause::position, parametric,
      powers<PowerPosition>(joint, {{0, false}, {1, true}, {1, false}, {2, true}, {2, false}, {3, true}}));
  add(Cause::velocity, parametric,
      powers<PowerVelocity>(joint, {{0.5, true}, {1, true}, {1, false}, {1.5, true}, {2, true}, {2, false}}));
  groups.back().terms.push_back({SignVelocity{kSettings.discrepancy.slow * s.speed}, joint});
  const auto with_position = {std::pair{0.0, false}, {1.0, true}, {1.0, false}, {2.0, false}};
  add(Cause::velocity, parametric, hinges<HingeVelocity>(joint, s.speed));
  Terms drags = powers<PowerDrag>(joint, with_position, true);
  append(drags, powers<PowerDrag>(joint, {{0, true}, {1, true}}, false));
  add(Cause::velocity, parametric, drags);
  add(Cause::velocity, parametric, powers<PowerDry>(joint, with_position, kSettings.discrepancy.slow * s.speed));
  if (driven) {
    add(Cause::input, parametric,
        powers<PowerInput>(joint, {{0.5, true}, {1, true}, {1, false}, {1.5, true}, {2, true}, {2, false}}));
    groups.back().terms.push_back({SignInput{kSettings.discrepancy.slow * s.input}, joint});
    add(Cause::history, parametric, slew_terms(s, joint));
    add(Cause::input, parametric, hinges<HingeInput>(joint, s.input));
    add(Cause::input, parametric, powers<PowerGain>(joint, with_position));
  }
  return groups;
}

}  // namespace bayesctrl
