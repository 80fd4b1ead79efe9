#pragma once

#include "diagnose/fit.hpp"

namespace bayesctrl {

/// A fit as it would be if parts of the recordings had been left out, by one step of the linear response: effects are
/// then judged by what they predict, as remainders are.
class LeftOutFit {
 public:
  /// `problem`, which the fit is of, must outlive this.
  LeftOutFit(const FitProblem& problem, const Fit& fit);

  /// Parameters without the windows of one fold (see folds_of); -1: of all. What acts in one recording only stays, for
  /// no other recording knows it.
  Fit without(int fold) const;

 private:
  const FitProblem& problem_;
  Fit fit_;
  Eigen::MatrixXd slopes_;  // rows of the response x unknowns
};

}  // namespace bayesctrl
