#include "diagnose/motion/rests.hpp"

#include "diagnose/settings.hpp"

namespace bayesctrl {

Rests rests_of(const LinearResponse& response, const Forcing& forcing) {
  Rests rests;
  rests.columns.resize(response.rows(), 0);
  for (int joint = 0; forcing.rests() && joint < joints(forcing.plant()); ++joint) {
    const std::vector<Eigen::MatrixXd> resting = forcing.resting(joint, kSettings.search.most_rests);
    const Eigen::Index count = resting.front().cols();
    if (count == 0) continue;
    rests.columns.conservativeResize(Eigen::NoChange, rests.columns.cols() + count);
    rests.columns.rightCols(count) = response.responses(resting);
    rests.joints.insert(rests.joints.end(), static_cast<std::size_t>(count), joint);
  }
  return rests;
}

Eigen::MatrixXd Rests::of(unsigned wanted) const {
  Eigen::MatrixXd result(columns.rows(), columns.cols());
  Eigen::Index count = 0;
  for (std::size_t i = 0; i < joints.size(); ++i) {
    if ((wanted >> joints[i]) & 1U) result.col(count++) = columns.col(static_cast<Eigen::Index>(i));
  }
  result.conservativeResize(Eigen::NoChange, count);
  return result;
}

}  // namespace bayesctrl
