#include "numerics/parallel.hpp"

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

namespace bayesctrl {

int core_count() { return std::max(1, tbb::info::default_concurrency()); }

void in_parallel(std::size_t count, int jobs, const std::function<void(std::size_t)>& work) {
  const int threads = jobs > 0 ? jobs : core_count();
  if (threads == 1 || count < 2) {
    for (std::size_t i = 0; i < count; ++i) work(i);
    return;
  }
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  tbb::task_arena arena(threads);
  arena.execute([&] { tbb::parallel_for(std::size_t{0}, count, work, tbb::simple_partitioner()); });
}

}  // namespace bayesctrl
