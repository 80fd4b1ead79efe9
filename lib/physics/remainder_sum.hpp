#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/remainder.hpp"

namespace bayesctrl {

/// The torque of a remainder, arranged for simulations: neighbouring terms that differ in centre, width and weight
/// alone stand in arrays, whose exponentials are taken together. The same numbers as those of Remainder, but for
/// rounding.
class RemainderSum {
 public:
  explicit RemainderSum(const Remainder& remainder);

  bool empty() const { return terms_.empty(); }

  /// As Remainder::torque and Remainder::advance.
  JointVector torque(const Remainder::Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
                     double t) const;
  void advance(Remainder::Memory& memory, const JointVector& q, const JointVector& v, const JointVector& u,
               double h) const;

 private:
  /// Terms `first`, `first` + 1, ... of one kind and joint, with the same number c.
  struct Batch {
    TermKind kind;
    int joint;
    double c;
    Eigen::Index first;
    Eigen::ArrayXd centre, per_width, weight;
  };

  Remainder::Limits limits_;
  std::vector<Term> terms_;
  std::vector<Batch> batches_;
  std::vector<std::size_t> single_;  // terms in no batch
};

}  // namespace bayesctrl
