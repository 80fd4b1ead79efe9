#include "control/monitor.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

bool SurpriseTest::operator()(double z) {
  if (!std::isfinite(z)) return false;
  const double alarm = -std::log(false_alarm_rate_);
  const double most = 0.7 * alarm;  // of one surprise
  for (std::size_t i = 0; i < kScales.size(); ++i) {
    const double s = kScales[i];
    log_ratio_[i] += std::min(0.5 * z * z * (1.0 - 1.0 / (s * s)) - std::log(s), most);
  }
  if (!(log_evidence() >= alarm)) return false;
  log_ratio_ = {};
  return true;
}

double SurpriseTest::log_evidence() const {
  const double largest = *std::max_element(log_ratio_.begin(), log_ratio_.end());
  double sum = 0.0;
  for (const double value : log_ratio_) sum += std::exp(value - largest);
  return largest + std::log(sum / static_cast<double>(kScales.size()));
}

}  // namespace bayesctrl
