#pragma once

#include "diagnose/fit/fit.hpp"

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

 private:
  const FitProblem& problem_;
  int joints_;
  std::vector<Machine> machines_;
  std::vector<std::vector<Drive>> drives_;
  std::vector<HiddenStates> hidden_;  // at the beginning of each window
};

/// Puts the residual of one window into that of the fit.
void take(const FitProblem& problem, Fit& fit, std::size_t w, const Eigen::MatrixXd& residual);

/// Sum of squares of the residual. Throws NumericalError where they are not finite.
void sum_up(Fit& fit);

}  // namespace bayesctrl
