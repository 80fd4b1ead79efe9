#pragma once

#include "diagnose/motion/forcing.hpp"
#include "diagnose/motion/linear_response.hpp"

namespace bayesctrl {

/// What dry friction may do while a joint rests: a torque of its own at each rest, which no level tells.
struct Rests {
  Eigen::MatrixXd columns;  // rows of the response x rests; an acceleration as large as the nominal's
  std::vector<int> joints;  // of each

  /// Those of these joints (one bit each).
  Eigen::MatrixXd of(unsigned wanted) const;
};

/// The longest rests of each joint.
Rests rests_of(const LinearResponse& response, const Forcing& forcing);

}  // namespace bayesctrl
