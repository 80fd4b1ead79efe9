#pragma once

#include "diagnose/motion/linear_response.hpp"

namespace bayesctrl {

/// What is left out in turn, for each window of the response: whole recordings, which is how a model will be used.
/// Where one of these parts holds nearly all that the target (rows) is beyond the noise, as a single recording does,
/// the others could not say anything about it, and every third window is left out instead.
std::vector<int> folds_of(const LinearResponse& response, const Eigen::VectorXd& target);

/// Linear models of a target that are judged by parts of it that were left out (cross-validation). What a model cannot
/// say is no white noise, and the evidence, which takes it for that, lets weights grow until they fit it.
class LeftOut {
 public:
  /// `columns` (rows x features) and `target` in units of the noise; `fold` of each row, 0 to `folds` - 1.
  LeftOut(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, const std::vector<int>& fold, int folds);

  /// Features with the deviations of their normal weights.
  struct Prior {
    std::vector<Eigen::Index> features;
    Eigen::VectorXd deviations;
  };

  /// SSE of each fold with weights learnt from the others, summed.
  double sse(const Prior& prior) const;

  /// Sum of squares of the target.
  double target_sse() const;

  /// Most probable weights of the features; without one fold if `without` is not -1.
  Eigen::VectorXd weights(const Prior& prior, int without = -1) const;

 private:
  struct Part {
    Eigen::MatrixXd gram;       // columns' columns
    Eigen::VectorXd projected;  // columns' target
    double sse = 0.0;
  };
  static Eigen::VectorXd weights_from(const Part& part, const Prior& prior);

  Part whole_;
  std::vector<Part> folds_, others_;  // of each fold, and of all others
};

}  // namespace bayesctrl
