#pragma once

#include <array>

#include "base/fields.hpp"

namespace bayesctrl {

/// What is learned in passing, and the test of whether the belief is over-confident.
struct Monitor {
  double period = 0.1;
  double false_alarm_rate = 0.01;

  static void fields(auto& self, auto&& field) {
    field("period", self.period, {kPositive, "s", "between two samples that are taken without a probe"});
    field("false_alarm_rate", self.false_alarm_rate,
          {{.low = 0.0, .high = 0.5, .low_open = true},
           "",
           "probability of ever raising an alarm while the prior is right"});
  }
  bool operator==(const Monitor&) const = default;
};

/// Sequential test of whether surprises z_k = (y_k - E y_k) / sd y_k, each by what was believed before, are larger than
/// N(0, 1) allows. Its evidence is the mean over s of prod_k N(z_k; 0, s^2) / N(z_k; 0, 1), a martingale of mean 1
/// under N(0, 1), which by Ville's inequality ever exceeds 1 / alpha with probability alpha at most. No single surprise
/// raises the alarm: its factor is cut off, which makes the evidence smaller and the bound still hold.
class SurpriseTest {
 public:
  explicit SurpriseTest(double false_alarm_rate) : false_alarm_rate_(false_alarm_rate) {}

  /// Takes one surprise. Returns whether the alarm is raised, after which the test begins anew.
  bool operator()(double z);

  /// Logarithm of the evidence.
  double log_evidence() const;

 private:
  static constexpr std::array kScales{1.25, 1.5, 2.0, 4.0, 8.0, 16.0, 64.0};
  double false_alarm_rate_;
  std::array<double, kScales.size()> log_ratio_{};
};

}  // namespace bayesctrl
