#pragma once

#include <algorithm>
#include <map>
#include <string>

#include "diagnose/discrepancy/term_groups.hpp"
#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// One number per cause.
using Shares = std::array<double, 5>;

/// A Gaussian process of the missing torque along a known motion, as features with normal weights (Kennedy & O'Hagan
/// 2001: a model discrepancy).
class Discrepancy {
 public:
  /// Terms that say together how the torque may depend on one cause.
  struct Group : TermGroup {
    Eigen::MatrixXd columns;  // response to each term, scaled to the prior
  };

  Discrepancy(const Linearisation& about, const std::vector<Measured>& data);

  /// What each cause explains alone of `target` (rows of the response), for the best joint.
  struct Dependence {
    Shares explained{};  // of the squares beyond the noise, 0 to 1
    int joint = 0;

    /// Of a missing torque; they sum to 1 (or are all 0). What explains all but a little is much more likely the cause
    /// than what explains half.
    Shares shares() const;
    Cause leads() const;
  };
  Dependence dependence(const Eigen::VectorXd& target) const;

  /// Log evidence of the best set of effects beside a discrepancy less that of the discrepancy alone, each with the
  /// size of the discrepancy that suits it best; that set; and of each effect, by its label, the probability that it
  /// is part of the machine, over all sets beside every kind and size of discrepancy.
  struct Beside {
    double log_odds = 0.0;
    std::vector<Effect> effects;
    std::map<std::string, double> inclusion;
  };
  Beside beside(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target, double penalty) const;

  const Linearisation& about() const { return about_; }
  const std::vector<Group>& groups() const { return groups_; }

 private:
  struct Ridge {
    double log_evidence = 0.0;
    double scale = 0.0;
    double explained = 0.0;
  };
  static Ridge ridge(const Eigen::MatrixXd& columns, const Eigen::VectorXd& target);

  /// The same from columns columns' (rows x rows, its lower half), for more columns than rows.
  static Ridge ridge_of(const Eigen::MatrixXd& covariance, const Eigen::VectorXd& target);

  const Linearisation& about_;
  std::vector<Group> groups_;
};

}  // namespace bayesctrl
