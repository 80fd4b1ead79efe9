#pragma once

namespace bayesctrl::testing {

/// Counts the heap allocations of this thread while it lives, by `new`, by Eigen and by anything else that calls
/// malloc. Counting is off otherwise. Not nested.
class AllocationCount {
 public:
  AllocationCount();
  ~AllocationCount();
  AllocationCount(const AllocationCount&) = delete;
  AllocationCount& operator=(const AllocationCount&) = delete;

  /// Since construction.
  long value() const;
};

/// Heap allocations made by f().
long allocations_of(auto&& f) {
  const AllocationCount count;
  f();
  return count.value();
}

}  // namespace bayesctrl::testing
