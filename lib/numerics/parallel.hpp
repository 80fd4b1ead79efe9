#pragma once

#include <cstddef>
#include <functional>

namespace bayesctrl {

/// Cores of this machine, at least 1.
int core_count();

/// Calls work(i) for each i < count from `jobs` threads, 0: one per core. An exception ends what has not begun and is
/// passed on. (oneTBB)
void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

}  // namespace bayesctrl
