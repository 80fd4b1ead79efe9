#pragma once

#include <memory>

#include "diagnose/search/explain.hpp"

namespace bayesctrl {

/// Recordings before samples were left out: what a set that nearly explains the thinned ones leaves of them.
class Whole {
 public:
  /// `result` says with what the search began, and must outlive this.
  Whole(const Explanation& result, const std::vector<Measured>& recordings, const ExplainOptions& options)
      : result_(result), recordings_(recordings), options_(options) {}

  /// Root mean square beyond the noise, in units of it, when the set is fitted to them from where it is; infinite where
  /// it cannot be simulated.
  double excess(const Fit& fit);

 private:
  const Explanation& result_;
  const std::vector<Measured>& recordings_;
  ExplainOptions options_;
  std::shared_ptr<Linearisation> about_;  // without a dictionary
  double max_step_ = 0.0;
};

}  // namespace bayesctrl
