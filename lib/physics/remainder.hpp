#pragma once

#include <array>
#include <complex>
#include <span>
#include <string_view>
#include <vector>

#include "base/vector.hpp"

namespace bayesctrl {

/// On what a torque may depend.
enum class Cause { position, velocity, input, time, history };
constexpr std::array<std::string_view, 5> names(Cause) { return {"position", "velocity", "input", "time", "history"}; }

/// Form of one term. "a" to "d" are the term's numbers, m its memory, sgn a sign that is smooth over 1 % of the range.
enum class TermKind {
  bump_position,   // exp(-(q - a)^2 / 2 b^2)
  bump_velocity,   // exp(-(v - a)^2 / 2 b^2)
  sign_velocity,   // tanh(v / a)
  bump_input,      // exp(-(u - a)^2 / 2 b^2)
  sign_input,      // tanh(u / a)
  bump_time,       // exp(-(t - a)^2 / 2 b^2)
  bump_state,      // exp(-(q - a)^2 / 2 b^2 - (v - c)^2 / 2 d^2)
  position_drag,   // exp(-(q - a)^2 / 2 b^2) v
  position_dry,    // exp(-(q - a)^2 / 2 b^2) tanh(v / c)
  position_gain,   // exp(-(q - a)^2 / 2 b^2) u
  velocity_gain,   // exp(-(v - a)^2 / 2 b^2) u
  time_gain,       // exp(-(t - a)^2 / 2 b^2) u
  time_drag,       // exp(-(t - a)^2 / 2 b^2) v
  power_position,  // |q|^a, with the sign of q if b is not 0
  power_velocity,  // |v|^a, with the sign of v if b is not 0
  power_input,     // |u|^a, with the sign of u if b is not 0
  power_drag,      // |q|^a |v|, with the sign of q if b is not 0, of v if c is not 0
  power_dry,       // |q|^a tanh(v / c), with the sign of q if b is not 0
  power_gain,      // |q|^a u, with the sign of q if b is not 0
  hinge_velocity,  // b max(b (v - a), 0), b 1 or -1
  hinge_input,     // b max(b (u - a), 0), b 1 or -1
  late_input,      // m - u, m' = (u - m) / a
  late_velocity,   // m - v, m' = (v - m) / a
  late_position,   // m - q, m' = (q - m) / a
  slew_input,      // m - u, m follows u at a per second at most
  past_input,      // m, m' = (exp(-(u - a)^2 / 2 b^2) - m) / c
  past_velocity,   // m, m' = (exp(-(v - a)^2 / 2 b^2) - m) / c
  late_push,       // m, m' = (tanh(u / a) - m) / c
  late_drag,       // m, m' = (tanh(v / a) - m) / c
  warm_viscous,    // m v, m' = (v^2 - m) / a
  warm_dry,        // m tanh(v / b), m' = (v^2 - m) / a
  warm_motor,      // m u, m' = (u^2 - m) / a
  play,            // m - q, m follows q at the ends of a gap of half-width a
  relay,           // tanh((m - a) / b), m follows q at the ends of a gap of half-width c
  swing,           // Re m - q, m' = w (q - m), w = a (b - i sqrt(1 - b^2)): a mass on a spring follows the joint
  swing_beside,    // Im m of the same
  ring_input,      // Re m - u, m' = w (u - m), w as above: what the input drives swings first
  ring_beside,     // Im m of the same
  reversal,        // exp(-m / a) tanh(v / b), m the time since the velocity changed its sign
};
constexpr std::array<std::string_view, 39> names(TermKind) {
  return {"bump_position", "bump_velocity",  "sign_velocity",  "bump_input",    "sign_input",    "bump_time",
          "bump_state",    "position_drag",  "position_dry",   "position_gain", "velocity_gain", "time_gain",
          "time_drag",     "power_position", "power_velocity", "power_input",   "power_drag",    "power_dry",
          "power_gain",    "hinge_velocity", "hinge_input",    "late_input",    "late_velocity", "late_position",
          "slew_input",    "past_input",     "past_velocity",  "late_push",     "late_drag",     "warm_viscous",
          "warm_dry",      "warm_motor",     "play",           "relay",         "swing",         "swing_beside",
          "ring_input",    "ring_beside",    "reversal"};
}

/// What the value of a term that does not go on is a function of, besides the time.
struct Looks {
  bool position = false, velocity = false, input = false;
};
Looks looks_at(TermKind kind);

/// Whether a term holds beyond what was seen: it is linear in the motion, or a law of few numbers.
bool goes_on(TermKind kind);

/// What a term remembers: a number, the position of a pointer for what swings.
using Held = std::complex<double>;

/// One term of a torque that no catalogue explains.
struct Term {
  TermKind kind = TermKind::bump_position;
  int joint = 0;
  int recording = -1;  // the only one in which it acts; -1: all
  double a = 0.0, b = 1.0, c = 0.0, d = 1.0;
  double weight = 1.0;  // N m

  bool operator==(const Term&) const = default;

  /// Value without the weight. `held`: memory.
  double value(double q, double v, double u, double t, Held held) const;

  /// Memory after `h` seconds at q, v, u. At first the input has been 0 for long, as with delays, the rest as it is.
  Held remembered(Held held, double q, double v, double u, double h) const;
  double first_memory(double q, double v) const;
};

/// A torque in the joints that is a sum of terms: the posterior mean of Gaussian processes over what the missing torque
/// depends on, written in features.
struct Remainder {
  /// What the terms have seen of one joint. Beyond it a law goes on; any other function of the velocity or of the input
  /// alone stays as it is at the edge, of the position, or of several, it fades away.
  struct Region {
    double lowest = 0.0, highest = 0.0, speed = 0.0, input = 0.0;
    double torque = 1e300;  // largest that is given
    bool operator==(const Region&) const = default;
  };
  std::vector<Term> terms;
  std::vector<Region> regions;  // one per joint, or none

  bool empty() const { return terms.empty(); }
  bool operator==(const Remainder&) const = default;

  using Memory = std::vector<Held>;  // one per term
  Memory begin(const JointVector& q, const JointVector& v) const;
  void advance(Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u, double h) const;
  JointVector torque(const Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                     double t) const;

  /// What terms look at.
  struct Point {
    JointVector q, v, u;
  };

  /// What keeps a remainder within what it has seen.
  struct Limits {
    explicit Limits(const Remainder& remainder);

    /// The nearest point that was seen.
    Point seen(const Point& at) const;

    /// What fades at the nearest point that was seen, and what goes on: together, bounded.
    JointVector limited(JointVector fading, const JointVector& going_on, const Point& seen, const Point& at) const;

    std::vector<Region> regions;
    Looks looks;           // of all terms together that do not go on
    bool several = false;  // they look at more than one thing
  };
};

}  // namespace bayesctrl
