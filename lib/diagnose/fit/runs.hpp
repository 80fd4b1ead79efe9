#pragma once

#include <algorithm>
#include <memory>
#include <utility>

#include "diagnose/fit/fit.hpp"
#include "numerics/parallel.hpp"

namespace bayesctrl {

/// Simulates windows of a fit's model. The problem must outlive it.
class Runs {
 public:
  Runs(const FitProblem& problem, const Fit& fit);

  /// Simulated positions of one window, samples x joints. Throws NumericalError.
  Eigen::MatrixXd operator()(std::size_t w, const SegmentState& start, Eigen::MatrixXd* states = nullptr) const;

  /// 1 / variance a priori of a segment's initial state.
  SegmentState precision(std::size_t w, const SegmentState& start) const;

  /// How far its components reach.
  SegmentState reach(std::size_t w, const SegmentState& start) const;

  /// Measured less simulated.
  Eigen::MatrixXd residual(std::size_t w, const SegmentState& start) const;

  /// Of the recording of a window.
  const Machine& machine(std::size_t w) const { return machines_[problem_.response.windows()[w].recording]; }

  /// Whether several threads may simulate at a time; else each needs a copy.
  bool may_be_shared() const { return shared_; }

 private:
  const FitProblem& problem_;
  int joints_;
  std::vector<Machine> machines_;
  bool shared_;
  std::shared_ptr<const std::vector<std::vector<Drive>>> drives_;  // per recording and joint
  std::vector<HiddenStates> hidden_;                               // at the beginning of each window
};

/// Calls work(runs, w) for each of the first `count` windows, on all threads. `runs`: those of one fit or more.
void each_window(const std::vector<Runs>& runs, std::size_t count, const auto& work) {
  if (thread_count() == 1 || std::ranges::all_of(runs, &Runs::may_be_shared)) {
    return in_parallel(count, [&](std::size_t w) { work(runs, w); });
  }
  const std::size_t blocks = std::min(count, static_cast<std::size_t>(thread_count()));
  in_parallel(blocks, [&](std::size_t b) {
    const std::vector<Runs> own = runs;
    for (std::size_t w = b * count / blocks; w < (b + 1) * count / blocks; ++w) work(own, w);
  });
}
void each_window(Runs runs, std::size_t count, const auto& work) {
  std::vector<Runs> one;
  one.push_back(std::move(runs));
  each_window(one, count, [&](const std::vector<Runs>& own, std::size_t w) { work(own.front(), w); });
}

/// Puts the residual of one window into that of the fit.
void take(const FitProblem& problem, Fit& fit, std::size_t w, const Eigen::MatrixXd& residual);

/// Sum of squares of the residual. Throws NumericalError where they are not finite.
void sum_up(Fit& fit);

}  // namespace bayesctrl
