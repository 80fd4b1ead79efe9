#include <benchmark/benchmark.h>

#include <chrono>
#include <filesystem>

#include "numerics/parallel.hpp"
#include "sweep/run.hpp"

using namespace bayesctrl;
namespace fs = std::filesystem;

namespace {

constexpr int kRuns = 3000;

double seconds_of(auto&& work) {
  const auto begin = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

/// Runs of SP1 of Experiment 1, alone and as a sweep that writes its files on one core and on all. Counters: runs per
/// second and core; efficiency: speed on all cores over that on one, per core; overhead: what a sweep on one core takes
/// longer than its runs alone.
void sweep_of_experiment_1(benchmark::State& state) {
  const fs::path folder = fs::temp_directory_path() / "bayesctrl-bench-sweep";
  fs::remove_all(folder);
  const SweepPlan plan =
      plan_sweep({fs::path(BAYESCTRL_SOURCE_DIR) / "configs" / "exp1.yaml",
                  "study",
                  {"sweep={repeat: " + std::to_string(kRuns) + "}", "controllers={SP1: {type: adaptive}}"},
                  0},
                 folder);
  const int cores = core_count();
  double alone = 0.0, one = 0.0, all = 0.0;
  for (auto _ : state) {
    alone += seconds_of([&] {
      for (int run = 0; run < kRuns; ++run) benchmark::DoNotOptimize(plan.run(run, {}));
    });
    for (const int jobs : {1, cores}) {
      SweepRunOptions options;
      options.jobs = jobs;
      fs::remove_all(folder / "results");
      (jobs == 1 ? one : all) += seconds_of([&] { run_sweep(plan, folder, options); });
    }
  }
  const double runs = static_cast<double>(kRuns) * static_cast<double>(state.iterations());
  state.counters["one_core"] = runs / one;
  state.counters["per_core"] = runs / all / cores;
  state.counters["efficiency"] = one / all / cores;
  state.counters["overhead"] = one / alone - 1.0;
  fs::remove_all(folder);
}
BENCHMARK(sweep_of_experiment_1)->Unit(benchmark::kSecond)->UseRealTime()->MinTime(1.0);

}  // namespace
