#include "diagnose/motion/spectrum.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace bayesctrl {

namespace {

/// Means of the missing torque over bins of `width` seconds, less their mean, and the bins' times.
struct Binned {
  std::vector<double> time, torque;
};

Binned binned(const std::vector<Measured>& data, const std::vector<Trajectory>& paths, int joint, double width) {
  Binned result;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const std::vector<double>& t = data[r].time;
    for (std::size_t k = 0; k < t.size();) {
      const double bin = std::floor(t[k] / width);
      double time = 0.0, torque = 0.0, samples = 0.0;
      for (; k < t.size() && std::floor(t[k] / width) == bin; ++k) {
        time += t[k];
        torque += paths[r].missing_torque(static_cast<Eigen::Index>(k), joint);
        samples += 1.0;
      }
      result.time.push_back(time / samples);
      result.torque.push_back(torque / samples);
    }
  }
  double mean = 0.0;
  for (const double torque : result.torque) mean += torque / static_cast<double>(result.torque.size());
  for (double& torque : result.torque) torque -= mean;
  return result;
}

}  // namespace

std::vector<double> strongest_frequencies(const std::vector<Measured>& data, const std::vector<Trajectory>& paths,
                                          int joint, double step, double highest, std::size_t count) {
  constexpr double kPerPeriod = 4.0;  // bins in the shortest period
  const Binned d = binned(data, paths, joint, 2.0 * std::numbers::pi / (kPerPeriod * highest));
  const auto samples = static_cast<Eigen::Index>(d.time.size());
  const Eigen::Map<const Eigen::ArrayXd> t(d.time.data(), samples), torque(d.torque.data(), samples);
  const Eigen::ArrayXd turn_re = (step * t).cos(), turn_im = -(step * t).sin();
  Eigen::ArrayXd re = torque, im = Eigen::ArrayXd::Zero(samples), before(samples);  // d exp(-i w t), turned on and on
  std::vector<double> power;
  for (double frequency = 0.0; frequency <= highest + step; frequency += step) {
    power.push_back(re.sum() * re.sum() + im.sum() * im.sum());
    before = re;
    re = before * turn_re - im * turn_im;
    im = before * turn_im + im * turn_re;
  }
  std::vector<std::size_t> peaks;
  for (std::size_t i = 1; i + 1 < power.size(); ++i) {
    if (power[i] >= power[i - 1] && power[i] > power[i + 1]) peaks.push_back(i);
  }
  std::ranges::sort(peaks, [&](std::size_t a, std::size_t b) { return power[a] > power[b]; });
  peaks.resize(std::min(count, peaks.size()));
  std::ranges::sort(peaks);
  std::vector<double> list;
  for (const std::size_t i : peaks) {
    if (const double frequency = step * static_cast<double>(i); i >= 2 && frequency < highest)
      list.push_back(frequency);
  }
  return list;
}

}  // namespace bayesctrl
