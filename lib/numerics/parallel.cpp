#include "numerics/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace bayesctrl {

namespace {

/// The exception of the least i that has thrown.
class FirstFailure {
 public:
  void run(std::size_t i, const std::function<void(std::size_t)>& work) {
    if (i > at_.load(std::memory_order_relaxed)) return;
    try {
      work(i);
    } catch (...) {
      const std::lock_guard lock(mutex_);
      if (i > at_) return;
      at_ = i;
      thrown_ = std::current_exception();
    }
  }

  void pass_on() const {
    if (thrown_) std::rethrow_exception(thrown_);
  }

 private:
  std::atomic<std::size_t> at_{std::numeric_limits<std::size_t>::max()};
  std::mutex mutex_;
  std::exception_ptr thrown_;
};

#ifdef __SANITIZE_THREAD__
/// oneTBB's library is not compiled with the thread sanitizer, which takes each task that it hands on for a race.
thread_local int given = 0;

void spread(std::size_t count, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::vector<std::jthread> pool;
  for (int t = 0; t < thread_count(); ++t) {
    pool.emplace_back([&] {
      given = 1;
      for (std::size_t i = next++; i < count; i = next++) work(i);
    });
  }
}
#else
/// A thread that waits for the loop takes no work of the loops around it.
void spread(std::size_t count, const std::function<void(std::size_t)>& work) {
  tbb::this_task_arena::isolate([&] { tbb::parallel_for(std::size_t{0}, count, work, tbb::simple_partitioner()); });
}
#endif

}  // namespace

int core_count() { return std::max(1, tbb::info::default_concurrency()); }

#ifdef __SANITIZE_THREAD__
void on_threads(int threads, const std::function<void()>& work) {
  struct Given {
    int before;
    ~Given() { given = before; }
  } restored{std::exchange(given, threads)};
  work();
}

int thread_count() { return given > 0 ? given : core_count(); }
#else
void on_threads(int threads, const std::function<void()>& work) {
  const int count = threads > 0 ? threads : core_count();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(count));
  tbb::task_arena arena(count);
  arena.execute(work);
}

int thread_count() { return tbb::this_task_arena::max_concurrency(); }
#endif

void in_parallel(std::size_t count, const std::function<void(std::size_t)>& work) {
  if (count < 2 || thread_count() < 2) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  FirstFailure failure;
  spread(count, [&](std::size_t i) { failure.run(i, work); });
  failure.pass_on();
}

void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  on_threads(jobs, [&] { in_parallel(count, work); });
}

}  // namespace bayesctrl
