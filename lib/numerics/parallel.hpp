#pragma once

#include <cstddef>
#include <functional>

namespace bayesctrl {

/// Cores of this machine, at least 1.
int core_count();

/// Calls work(), whose loops in parallel have so many threads, 0: one per core; no more than a call around it gave.
void on_threads(int threads, const std::function<void()>& work);

/// Threads of loops in parallel that begin here: as many as were given, without that one per core.
int thread_count();

/// Calls work(i) for each i < count in any order, on the threads that are given here; a loop within a loop takes those
/// that are free. Of several exceptions that of the least i is passed on, whatever the threads; what comes after it
/// may be left out. (oneTBB)
void in_parallel(std::size_t count, const std::function<void(std::size_t)>& work);

/// The same on `jobs` threads; 0: one per core.
void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work);

}  // namespace bayesctrl
