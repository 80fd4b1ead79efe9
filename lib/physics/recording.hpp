#pragma once

#include <Eigen/Core>
#include <vector>

namespace bayesctrl {

/// Sampled motion of one machine, simulated or measured. Rows are samples, columns joints (inputs). The input of a row
/// is held until the next row.
struct Recording {
  std::vector<double> time;  // s, increasing
  Eigen::MatrixXd position;  // rad or m
  Eigen::MatrixXd velocity;  // rad/s or m/s
  Eigen::MatrixXd input;     // N m or N

  Eigen::Index samples() const { return static_cast<Eigen::Index>(time.size()); }
};

}  // namespace bayesctrl
