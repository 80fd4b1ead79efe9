#pragma once

#include <map>
#include <optional>

#include "diagnose/discrepancy/discrepancy.hpp"
#include "diagnose/discrepancy/left_out.hpp"

namespace bayesctrl {

/// Remainders for what is missing in one joint: of which groups of terms, with weights of which size, is what predicts
/// left-out recordings best in the linear response.
class RemainderSearch {
 public:
  /// `target`: rows of the response that `discrepancy` is about; `on`: what causes it; `folds` of the windows.
  RemainderSearch(const Discrepancy& discrepancy, const Eigen::VectorXd& target, const Discrepancy::Dependence& on,
                  std::vector<int> folds);

  /// Groups that a remainder consists of, with the deviation of their weights.
  struct Basis {
    std::vector<std::size_t> groups;  // places among those that may be used
    std::vector<double> deviations;
    double left = 0.0;        // SSE of what was left out
    bool parametric = false;  // all groups are
  };

  /// Those that are worth a try in free runs, of parametric groups and of all others: the best group, and the set that
  /// is built from it one group at a time. None if none predicts anything.
  std::vector<Basis> best();

  /// What each cause predicts alone of the SSE beyond the noise that was left out, 0 to 1: the best of its
  /// groups, products of two causes and parametric ones among them.
  Shares predicted();

  /// That of the leading cause.
  Basis leading() const;

  /// The torque that explains the target best; without the windows of one fold if `left_out` is not -1.
  Remainder remainder(const Basis& basis, int left_out = -1) const;

 private:
  std::vector<Basis> best_of(bool parametric);
  const Basis& alone(std::size_t group);
  LeftOut::Prior prior(const Basis& basis) const;
  void with_best_deviation(Basis& basis) const;  // of its last group

  const Discrepancy& discrepancy_;
  Discrepancy::Dependence on_;
  std::vector<int> folds_;
  std::vector<std::size_t> groups_;  // that may be used
  std::vector<Term> terms_;          // of all of them
  std::vector<Eigen::Index> first_;  // of each group's terms, and the end
  std::optional<LeftOut> left_out_;
  std::map<std::size_t, Basis> alone_;  // groups one by one, of those that were asked for
};

}  // namespace bayesctrl
