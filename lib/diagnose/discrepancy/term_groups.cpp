#include "diagnose/discrepancy/term_groups.hpp"

#include <algorithm>
#include <optional>
#include <utility>

namespace bayesctrl {

namespace {

constexpr int kBumps = 36;             // along each input
constexpr int kFineBumps = 72;         // where edges are sharp
constexpr int kStateBumps = 7;         // along each side of the grid over position and velocity
constexpr int kProductBumps = 18;      // along the first of two causes
constexpr int kPastBumps = 12;         // along what is remembered, for each time constant
constexpr double kTimeStep = 0.1;      // s between bumps in time, the same in all recordings
constexpr double kSlowStep = 3.0;      // s between bumps in the time of one recording
constexpr double kChangeStep = 0.25;   // s between bumps in time of what changes a gain or a drag
constexpr int kRelays = 12;            // along the positions
constexpr double kSlowestSwing = 4.0;  // rad/s
constexpr double kFastestSwing = 40.0;
constexpr double kRare = 0.05;  // of the samples, on either side of where fine terms lie
constexpr double kSlow = 0.01;  // of the highest speed: dry friction is smooth over it

using Terms = std::vector<Term>;

Terms bumps(TermKind kind, int joint, double low, double high, int count, int recording = -1) {
  const double step = std::max(high - low, 1e-9) / (count - 1);
  Terms list;
  for (int i = 0; i < count; ++i) list.push_back({kind, joint, recording, low + i * step, step});
  return list;
}

void append(Terms& list, const Terms& more) { list.insert(list.end(), more.begin(), more.end()); }

Terms with_c(Terms list, double c) {
  for (Term& term : list) term.c = c;
  return list;
}

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
  return {at(kRare), at(1.0 - kRare)};
}

Terms velocity_terms(const Survey& s, int joint) {
  Terms list = bumps(TermKind::bump_velocity, joint, -s.speed, s.speed, kBumps);
  for (const double part : {0.005, 0.03, 0.15}) list.push_back({TermKind::sign_velocity, joint, -1, part * s.speed});
  return list;
}

Terms input_terms(const Survey& s, int joint) {
  Terms list = bumps(TermKind::bump_input, joint, -s.input, s.input, kBumps);
  for (const double part : {0.01, 0.1}) list.push_back({TermKind::sign_input, joint, -1, part * s.input});
  return list;
}

/// Quick in what all recordings share, slow in each one alone.
Terms time_terms(const Survey& s, int joint) {
  const double longest = *std::max_element(s.durations.begin(), s.durations.end());
  Terms list = bumps(TermKind::bump_time, joint, 0.0, longest, std::max(4, static_cast<int>(longest / kTimeStep)));
  for (std::size_t r = 0; r < s.durations.size(); ++r) {
    append(list, bumps(TermKind::bump_time, joint, 0.0, s.durations[r],
                       std::max(2, static_cast<int>(s.durations[r] / kSlowStep) + 1), static_cast<int>(r)));
  }
  return list;
}

/// A gain or a drag that changes in time, alike in all recordings.
Terms changing_terms(TermKind kind, const Survey& s, int joint) {
  const double longest = *std::max_element(s.durations.begin(), s.durations.end());
  return bumps(kind, joint, 0.0, longest, std::max(4, static_cast<int>(longest / kChangeStep)));
}

/// What a term of the past is compared with: beside it, as a term of its own, the past may act alone.
std::optional<TermKind> present(TermKind past) {
  switch (past) {
    case TermKind::late_input:
      return TermKind::power_input;
    case TermKind::late_velocity:
      return TermKind::power_velocity;
    case TermKind::late_position:
      return TermKind::power_position;
    default:
      return {};
  }
}

/// What the past leaves behind, each in one form.
std::vector<Terms> histories(const Survey& s, int joint) {
  std::vector<Terms> list;
  const auto add = [&](TermKind kind, double b = 1.0) {
    Terms& terms = list.emplace_back();
    for (const double tau : {0.03, 0.1, 0.3, 1.0, 3.0}) terms.push_back({kind, joint, -1, tau, b});
    if (const auto now = present(kind)) terms.push_back({*now, joint, -1, 1.0, 1.0});
  };
  if (s.input > 0.0) {
    add(TermKind::late_input);
    add(TermKind::warm_motor);
  }
  add(TermKind::late_velocity);
  add(TermKind::late_position);
  add(TermKind::warm_viscous);
  add(TermKind::warm_dry, kSlow * s.speed);
  add(TermKind::reversal, kSlow * s.speed);
  Terms& plays = list.emplace_back();
  for (const double part : {0.005, 0.02, 0.06, 0.15, 0.3}) {
    plays.push_back({TermKind::play, joint, -1, part * (s.highest - s.lowest)});
  }
  return list;
}

/// Of one input, or of the position times something else: |x|^a, even and odd.
Terms powers(TermKind kind, int joint, std::initializer_list<std::pair<double, bool>> exponents, double c = 0.0) {
  Terms list;
  for (const auto& [a, odd] : exponents) list.push_back({kind, joint, -1, a, odd ? 1.0 : 0.0, c});
  return list;
}

/// Linear from a threshold on, on either side.
Terms hinges(TermKind kind, int joint, double most) {
  Terms list;
  for (const double part : {0.0, 0.05, 0.1, 0.2, 0.35, 0.55}) {
    for (const double side : {-1.0, 1.0}) list.push_back({kind, joint, -1, side * part * most, side});
  }
  return list;
}

Terms state_terms(const Survey& s, int joint) {
  const double dq = (s.highest - s.lowest) / (kStateBumps - 1), dv = 2.0 * s.speed / (kStateBumps - 1);
  Terms list;
  for (int a = 0; a < kStateBumps; ++a) {
    for (int b = 0; b < kStateBumps; ++b) {
      list.push_back({TermKind::bump_state, joint, -1, s.lowest + a * dq, dq, -s.speed + b * dv, dv});
    }
  }
  return list;
}

/// Low-passed functions of what was between -most and most.
Terms past_terms(TermKind kind, int joint, double most) {
  Terms list;
  for (const double tau : {0.1, 0.3, 1.0}) append(list, with_c(bumps(kind, joint, -most, most, kPastBumps), tau));
  return list;
}

/// The same of functions that saturate: few, and known beyond what was seen.
Terms late_terms(TermKind kind, int joint, double most) {
  Terms list;
  for (const double tau : {0.1, 0.3, 1.0}) {
    for (const double part : {0.1, 0.3, 1.0}) list.push_back({kind, joint, -1, part * most, 1.0, tau});
  }
  return list;
}

/// Whether the joint has come from above or from below: hysteresis.
Terms relay_terms(const Survey& s, int joint) {
  const double range = s.highest - s.lowest, step = range / kRelays;
  Terms list;
  for (const double part : {0.03, 0.08, 0.15, 0.25, 0.35}) {
    for (int i = 1; i < kRelays; ++i) {
      list.push_back({TermKind::relay, joint, -1, s.lowest + i * step, 0.25 * step, part * range});
    }
  }
  return list;
}

/// Masses on springs that the joint carries along, or that the input drives.
Terms swing_terms(TermKind kind, TermKind beside, int joint) {
  Terms list;
  for (const auto& [damping, ratio] : {std::pair{0.04, 1.12}, {0.25, 1.5}}) {
    for (double frequency = kSlowestSwing; frequency < kFastestSwing; frequency *= ratio) {
      list.push_back({kind, joint, -1, frequency, damping});
      list.push_back({beside, joint, -1, frequency, damping});
    }
  }
  return list;
}

/// Input that follows at limited rates.
Terms slew_terms(const Survey& s, int joint) {
  Terms list;
  for (const double rate : {1.0, 2.0, 5.0, 10.0, 20.0, 50.0}) {
    list.push_back({TermKind::slew_input, joint, -1, rate * s.input});
  }
  return list;
}

}  // namespace

std::vector<TermGroup> term_groups(const Survey& s, const std::vector<Trajectory>& paths, int joint) {
  std::vector<TermGroup> groups;
  const auto add = [&](Cause cause, TermUse use, Terms terms) {
    groups.push_back({cause, use, joint, std::move(terms)});
  };
  using enum TermUse;
  const bool driven = s.input > 0.0;
  add(Cause::position, compare, bumps(TermKind::bump_position, joint, s.lowest, s.highest, kBumps));
  add(Cause::velocity, compare, velocity_terms(s, joint));
  if (driven) add(Cause::input, compare, input_terms(s, joint));
  add(Cause::time, compare, time_terms(s, joint));
  const std::vector<Terms> forms = histories(s, joint);
  Terms history;
  for (const Terms& form : forms) append(history, form);
  add(Cause::history, compare, history);
  add(Cause::velocity, rich, state_terms(s, joint));
  add(Cause::velocity, rich, bumps(TermKind::position_drag, joint, s.lowest, s.highest, kProductBumps));
  add(Cause::velocity, rich,
      with_c(bumps(TermKind::position_dry, joint, s.lowest, s.highest, kProductBumps), kSlow * s.speed));
  if (driven) {
    add(Cause::input, rich, bumps(TermKind::position_gain, joint, s.lowest, s.highest, kProductBumps));
    add(Cause::input, rich, bumps(TermKind::velocity_gain, joint, -s.speed, s.speed, kProductBumps));
    add(Cause::input, rich, bumps(TermKind::bump_input, joint, -s.input, s.input, kFineBumps));
    add(Cause::time, rich, changing_terms(TermKind::time_gain, s, joint));
    add(Cause::history, rich, past_terms(TermKind::past_input, joint, s.input));
    add(Cause::history, rich, late_terms(TermKind::late_push, joint, s.input));
    add(Cause::history, rich, swing_terms(TermKind::ring_input, TermKind::ring_beside, joint));
  }
  add(Cause::time, rich, changing_terms(TermKind::time_drag, s, joint));
  add(Cause::history, rich, past_terms(TermKind::past_velocity, joint, s.speed));
  add(Cause::history, rich, late_terms(TermKind::late_drag, joint, s.speed));
  add(Cause::history, rich, relay_terms(s, joint));
  add(Cause::history, rich, swing_terms(TermKind::swing, TermKind::swing_beside, joint));
  const auto [left, right] = most_of(paths, &Trajectory::position, joint);
  add(Cause::position, rich, bumps(TermKind::bump_position, joint, left, right, kFineBumps));
  const auto [slowest, quickest] = most_of(paths, &Trajectory::velocity, joint);
  add(Cause::velocity, rich, bumps(TermKind::bump_velocity, joint, slowest, quickest, kFineBumps));

  for (const Terms& form : forms) add(Cause::history, law, form);
  add(Cause::position, law,
      powers(TermKind::power_position, joint, {{0, false}, {1, true}, {1, false}, {2, true}, {2, false}, {3, true}}));
  add(Cause::velocity, law,
      powers(TermKind::power_velocity, joint,
             {{0.5, true}, {1, true}, {1, false}, {1.5, true}, {2, true}, {2, false}}));
  groups.back().terms.push_back({TermKind::sign_velocity, joint, -1, kSlow * s.speed});
  const auto with_position = {std::pair{0.0, false}, {1.0, true}, {1.0, false}, {2.0, false}};
  add(Cause::velocity, law, hinges(TermKind::hinge_velocity, joint, s.speed));
  Terms drags = powers(TermKind::power_drag, joint, with_position, 1.0);
  append(drags, powers(TermKind::power_drag, joint, {{0, true}, {1, true}}));
  add(Cause::velocity, law, drags);
  add(Cause::velocity, law, powers(TermKind::power_dry, joint, with_position, kSlow * s.speed));
  if (driven) {
    add(Cause::input, law,
        powers(TermKind::power_input, joint, {{0.5, true}, {1, true}, {1, false}, {1.5, true}, {2, true}, {2, false}}));
    groups.back().terms.push_back({TermKind::sign_input, joint, -1, kSlow * s.input});
    add(Cause::history, law, slew_terms(s, joint));
    add(Cause::input, law, hinges(TermKind::hinge_input, joint, s.input));
    add(Cause::input, law, powers(TermKind::power_gain, joint, with_position));
  }
  return groups;
}

}  // namespace bayesctrl
