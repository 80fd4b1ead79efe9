#pragma once

#include <vector>

#include "base/vector.hpp"
#include "physics/discrepancy/basis.hpp"

namespace bayesctrl {

/// One term of a torque that no catalogue explains.
struct Term {
  Basis basis;
  int joint = 0;
  int recording = -1;   // the only one in which it acts; -1: all
  double weight = 1.0;  // N m

  bool operator==(const Term&) const = default;

  /// Value without the weight. `held`: memory.
  double value(const Instant& at, const Held& held) const;

  /// Memory after `h` seconds at one instant. At first the input has been 0 for long, as with delays, the rest as it
  /// is.
  Held remembered(const Held& held, const Instant& at, double h) const;
  Held first_memory(double position, double velocity) const;
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

    Instant of(int joint, double time) const { return {q[joint], v[joint], u[joint], time}; }
  };

  /// What keeps a remainder within what it has seen.
  struct Limits {
    explicit Limits(const Remainder& remainder);

    /// The nearest point that was seen.
    Point seen(const Point& at) const;

    /// What fades at the nearest point that was seen, and what goes on: together, bounded.
    JointVector limited(JointVector fading, const JointVector& going_on, const Point& seen, const Point& at) const;

    std::vector<Region> regions;
    Looks looks;  // of all terms together that do not go on
  };
};

}  // namespace bayesctrl
