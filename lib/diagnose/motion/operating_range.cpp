#include "diagnose/motion/operating_range.hpp"

#include <algorithm>

namespace bayesctrl {

OperatingRange operating_range(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, int joint) {
  OperatingRange result;
  result.lowest = kInfinity;
  result.highest = -kInfinity;
  result.coldest = kInfinity;
  result.warmest = -kInfinity;
  result.period = shortest_sample_period(data);
  result.joints = static_cast<int>(data.front().position.cols());
  for (std::size_t r = 0; r < data.size(); ++r) {
    const auto q = paths[r].position.col(joint);
    result.lowest = std::min(result.lowest, q.minCoeff());
    result.highest = std::max(result.highest, q.maxCoeff());
    result.speed = std::max(result.speed, paths[r].velocity.col(joint).cwiseAbs().maxCoeff());
    result.input = std::max(result.input, data[r].input.col(joint).cwiseAbs().maxCoeff());
    result.durations.push_back(data[r].time.back());
    if (!data[r].temperature) continue;
    const auto celsius = data[r].temperature->celsius.col(joint);
    result.coldest = std::min(result.coldest, celsius.minCoeff());
    result.warmest = std::max(result.warmest, celsius.maxCoeff());
  }
  return result;
}

}  // namespace bayesctrl
