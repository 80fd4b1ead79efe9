// Loops in parallel: each once, within one another, and the same exception whatever the threads.

#include "numerics/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <thread>
#include <vector>

#include "base/error.hpp"
#include "io/examples.hpp"

using namespace bayesctrl;
using io_examples::error_of;

TEST_CASE("Work in parallel is done once each, by as many threads as are asked for, an exception arrives",
          "[numerics]") {
  for (const int jobs : {0, 1, 2, 5}) {
    std::vector<int> done(1000, 0);
    in_parallel(done.size(), jobs, [&](std::size_t i) { ++done[i]; });
    CHECK(done == std::vector<int>(1000, 1));
    on_threads(jobs, [&] {
      CHECK(thread_count() == (jobs > 0 ? jobs : core_count()));
      in_parallel(done.size(), [&](std::size_t i) { ++done[i]; });
    });
    CHECK(done == std::vector<int>(1000, 2));
  }
  CHECK(thread_count() == core_count());
}

TEST_CASE("Of several exceptions that of the first index arrives, and what comes before it is done", "[numerics]") {
  using namespace std::chrono_literals;
  for (const int jobs : {1, 2, 5}) {
    std::vector<int> done(60, 0);
    const auto fail = [&](std::size_t i) {
      if (i < 20) std::this_thread::sleep_for(1ms);  // so that later ones fail earlier
      if (i % 20 == 19) throw IoError("disk " + std::to_string(i));
      done[i] = 1;
    };
    CHECK(error_of<Error>([&] { in_parallel(done.size(), jobs, fail); }) == "disk 19");
    CHECK(std::count(done.begin(), done.begin() + 19, 1) == 19);
  }
}

TEST_CASE("A loop in a loop is done by the threads of the outer one", "[numerics]") {
  for (const int jobs : {1, 2, 3}) {
    std::atomic<int> now = 0, most = 0, done = 0;
    in_parallel(4, jobs, [&](std::size_t) {
      in_parallel(25, [&](std::size_t) {
        const int others = ++now;
        for (int seen = most; seen < others && !most.compare_exchange_weak(seen, others);) {
        }
        std::this_thread::sleep_for(std::chrono::microseconds(200));
        --now;
        ++done;
      });
    });
    CHECK(done == 100);
    CHECK(most <= jobs);
  }
}
