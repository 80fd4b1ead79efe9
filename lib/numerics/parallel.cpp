#include "numerics/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace bayesctrl {

namespace {

#ifdef __SANITIZE_THREAD__
/// oneTBB's library is not compiled with the thread sanitizer, which takes each task that it hands on for a race.
void spread(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr failed;
  std::mutex mutex;
  {
    std::vector<std::jthread> pool;
    for (int t = 0; t < threads; ++t) {
      pool.emplace_back([&] {
        for (std::size_t i = next++; i < count; i = next++) {
          try {
            work(i);
          } catch (...) {
            const std::lock_guard lock(mutex);
            failed = std::current_exception();
            next = count;
          }
        }
      });
    }
  }
  if (failed) std::rethrow_exception(failed);
}
#else
void spread(std::size_t count, int threads, const std::function<void(std::size_t)>& work) {
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, work, tbb::simple_partitioner()); });
}
#endif

}  // namespace

int core_count() { return std::max(1, tbb::info::default_concurrency()); }

void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  const int threads = jobs > 0 ? jobs : core_count();
  if (threads > 1 && count > 1) return spread(count, threads, work);
  for (std::size_t i = 0; i < count; ++i) work(i);
}

}  // namespace bayesctrl
