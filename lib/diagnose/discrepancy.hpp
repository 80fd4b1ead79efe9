#pragma once

#include <algorithm>

#include "diagnose/explain.hpp"
#include "diagnose/term_groups.hpp"

namespace bayesctrl {

/// What is left out in turn, by window: whole recordings, which is how a model will be used; of a single one every
/// third window.
inline constexpr int kFolds = 3;
std::vector<int> folds_of(const std::vector<Segment>& windows);

/// Shares of a missing torque that each cause explains alone; they sum to 1 (or are all 0).
using Shares = std::array<double, 5>;

/// A Gaussian process of the missing torque along a known motion, as features with normal weights (Kennedy & O'Hagan
/// 2001: a model discrepancy).
class Discrepancy {
 public:
  /// `joints` in which a torque may be missing.
  Discrepancy(const Linearisation& about, const std::vector<Measured>& data);

  /// What each cause explains alone of `target` (rows of the response), for the best joint.
  struct Dependence {
    Shares shares{};
    int joint = 0;

    Cause leads() const { return static_cast<Cause>(std::max_element(shares.begin(), shares.end()) - shares.begin()); }
  };
  Dependence dependence(const Eigen::VectorXd& target) const;

  /// Groups of terms of which a remainder may consist, those that predict left-out windows best first: that of the
  /// leading cause, or those that explain most together, one more at a time (time only if it leads, for its terms mean
  /// little elsewhere).
  using Basis = std::vector<std::size_t>;
  std::vector<Basis> bases(const Eigen::VectorXd& target, const Dependence& on) const;
  Basis leading(const Dependence& on) const;

  /// The torque that explains `target` best; without the windows of the fold `left_out` if that is not -1.
  Remainder remainder(const Eigen::VectorXd& target, const Basis& basis, int left_out = -1) const;

  /// Log evidence of the best set of effects beside a discrepancy less that of the discrepancy alone, each with the
  /// size of the discrepancy that suits it best; and that set.
  struct Beside {
    double log_odds = 0.0;
    std::vector<Effect> effects;
  };
  Beside beside(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, double penalty) const;

 private:
  struct Group : TermGroup {
    Eigen::MatrixXd columns;  // response to each term, scaled to the prior
  };
  struct Ridge {
    double log_evidence = 0.0;
    double scale = 0.0;
    double explained = 0.0;
    Eigen::VectorXd weights;
  };
  /// What is not explained may be the noise alone, or also what no term can say.
  enum class Noise { known, unknown };
  static Ridge ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, Noise noise = Noise::known);

  /// Responses to all terms of a basis, each group's scaled to what suits `target`.
  Eigen::MatrixXd columns_of(const Basis& basis, const Eigen::VectorXd& target) const;

  /// `target` with the rows of one fold's windows zero.
  Eigen::VectorXd without(int fold, const Eigen::VectorXd& target) const;

  /// What a basis leaves of windows that were left out, each no more than the worst of `target`.
  double left_out_squares(const Eigen::VectorXd& target, const Basis& basis) const;

  const Linearisation& about_;

  std::vector<Group> groups_;
};

}  // namespace bayesctrl
