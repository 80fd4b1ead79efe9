#pragma once

#include <Eigen/Core>
#include <vector>

#include "physics/discrepancy/remainder.hpp"

namespace bayesctrl {

/// The torque of a remainder, arranged for simulations: neighbouring terms of one basis are taken together, and where
/// they are bell curves that differ in centre, width and weight alone, so are their exponentials. The same numbers as
/// those of Remainder, but for rounding.
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
  /// Terms `first`, `first` + 1, ... of one basis and joint.
  struct Batch {
    std::size_t first = 0, count = 0;
    int joint = 0;
    Eigen::ArrayXd centre, per_width, weight;  // of bell curves
  };

  Remainder::Limits limits_;
  std::vector<Term> terms_;
  std::vector<Batch> batches_;
};

}  // namespace bayesctrl
