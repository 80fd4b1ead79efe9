#pragma once

#include <optional>
#include <vector>

#include "diagnose/fit/free_runs.hpp"
#include "diagnose/verdict/diagnosis.hpp"
#include "diagnose/verdict/judge.hpp"
#include "diagnose/verdict/units.hpp"
#include "io/table.hpp"

namespace bayesctrl {

/// Models whose free runs are compared.
struct Models {
  Corrected before, refit, after;
  std::optional<Corrected> with_remainder;  // where `after` leaves the remainder out
};

Models models_of(const Search& search, const Judgement& judgement);

/// How models compare over recordings.
struct Compared {
  FitErrors errors;
  Eigen::VectorXd before, after;  // RMS error of each joint,
  double samples = 0.0;           // over so many

  /// Of each joint's error before, the share that is left beyond the noise (standard deviation per joint) or that this
  /// hides: two standard deviations of the mean square.
  Eigen::VectorXd left(const Eigen::VectorXd& noise) const;
};

/// The runs are added to `runs`.
Compared compare(const Models& models, const Search& search, const std::vector<Measured>& recordings, bool held_out,
                 const std::vector<JointUnits>& units, Table& runs);

/// Held-out recordings refuse a remainder with which they are predicted clearly worse than without: it was learnt where
/// they are not.
void drop_refuted_remainder(Judgement& judgement, const Search& search, const std::vector<Measured>& held_out);

}  // namespace bayesctrl
