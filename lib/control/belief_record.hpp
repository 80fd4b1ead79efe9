#pragma once

#include <algorithm>
#include <vector>

#include "control/belief.hpp"

namespace bayesctrl {

/// What was believed at each control call, without covariances: as many numbers a call as the machine's joints take,
/// not the room of the most joints.
class BeliefRecord {
 public:
  /// Makes room, so that as many calls allocate nothing.
  void reserve(int joints, long calls) { numbers_.reserve(numbers_in(joints) * static_cast<std::size_t>(calls)); }

  bool empty() const { return numbers_.empty(); }

  void push_back(const BeliefMarginals& believed) {
    joints_ = static_cast<int>(believed.drift_mean.size());
    for_each_part(believed, [this](const auto& part) {
      numbers_.insert(numbers_.end(), part.data(), part.data() + part.size());
    });
  }

  /// Of a call that was recorded.
  BeliefMarginals operator[](std::size_t call) const {
    const int n = joints_;
    BeliefMarginals believed{JointVector(n),    JointVector(n), JointMatrix(n, n),
                             JointMatrix(n, n), JointVector(n), JointVector(n)};
    const double* next = numbers_.data() + call * numbers_in(n);
    for_each_part(believed, [&next](auto& part) {
      std::copy_n(next, part.size(), part.data());
      next += part.size();
    });
    return believed;
  }

 private:
  static std::size_t numbers_in(int joints) { return static_cast<std::size_t>(2 * joints * (joints + 2)); }

  static void for_each_part(auto& believed, auto&& f) {
    f(believed.drift_mean);
    f(believed.drift_variance);
    f(believed.gain_mean);
    f(believed.gain_variance);
    f(believed.log_gain_mean);
    f(believed.log_gain_variance);
  }

  int joints_ = 0;
  std::vector<double> numbers_;
};

}  // namespace bayesctrl
