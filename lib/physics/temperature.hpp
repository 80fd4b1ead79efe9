#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <memory>
#include <vector>

#include "base/vector.hpp"

namespace bayesctrl {

/// Degrees Celsius, where none is recorded, and at which coefficients hold.
inline constexpr double kReferenceTemperature = 20.0;

/// Of a machine's joints during one recording.
struct Temperature {
  std::vector<double> time;  // s since its start, increasing
  Eigen::MatrixXd celsius;   // samples x joints

  /// Of one joint: linear between samples, constant beyond.
  double at(int joint, double t) const {
    const auto after = static_cast<Eigen::Index>(std::upper_bound(time.begin(), time.end(), t) - time.begin());
    if (after == 0 || after == celsius.rows()) return celsius(after == 0 ? 0 : after - 1, joint);
    const double from = time[static_cast<std::size_t>(after - 1)], to = time[static_cast<std::size_t>(after)];
    const double s = (t - from) / (to - from);
    return (1.0 - s) * celsius(after - 1, joint) + s * celsius(after, joint);
  }
};

/// None: not recorded.
using RecordedTemperature = std::shared_ptr<const Temperature>;

/// Of all joints; empty where it is not recorded.
inline JointVector celsius_at(const RecordedTemperature& temperature, double t) {
  JointVector celsius(temperature ? temperature->celsius.cols() : 0);
  for (int j = 0; j < celsius.size(); ++j) celsius[j] = temperature->at(j, t);
  return celsius;
}

}  // namespace bayesctrl
