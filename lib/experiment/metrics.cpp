#include "experiment/metrics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace bayesctrl {

namespace {

constexpr double kNotApplicable = std::numeric_limits<double>::quiet_NaN();

const LoopStep* last(const Outcome& outcome) {
  return outcome.result.steps.empty() ? nullptr : &outcome.result.steps.back();
}

/// A run that never began has no integrals.
double integral(const Outcome& outcome, double value) { return last(outcome) ? value : kNotApplicable; }

double final_error(const LoopStep& step) {
  return std::sqrt((step.position - step.reference.position).squaredNorm() +
                   (step.velocity - step.reference.velocity).squaredNorm());
}

double peak_input(const LoopResult& result) {
  double peak = 0.0;
  for (const LoopStep& step : result.steps) peak = std::max(peak, step.input.cwiseAbs().maxCoeff());
  return peak;
}

/// When the position has come to stay near the reference: within 5 % of the first distance, or 0.05.
double settling_time(const LoopResult& result) {
  if (result.status != RunStatus::ok || result.steps.empty()) return kNotApplicable;
  const auto distance = [](const LoopStep& step) { return (step.position - step.reference.position).norm(); };
  const double band = std::max(0.05 * distance(result.steps.front()), 0.05);
  double settled = kNotApplicable;
  for (auto step = result.steps.rbegin(); step != result.steps.rend() && distance(*step) <= band; ++step) {
    settled = step->time;
  }
  return settled;
}

bool adaptive(const Outcome& outcome) { return outcome.result.belief.joints() > 0; }

bool watched(const Outcome& outcome) { return outcome.result.learning.monitored; }

double first_alarm(const LoopResult& result) {
  return result.learning.alarms.empty() ? kNotApplicable : result.learning.alarms.front();
}

/// What is worth a column only where it happened.
double if_any(int count) { return count > 0 ? count : kNotApplicable; }

double estimated_delay(const LoopResult& result) {
  const auto& timings = result.learning.timings;
  return timings ? latest(*timings).together() : kNotApplicable;
}

/// Microseconds of a control call that a share of them does not exceed.
double latency(const LoopResult& result, double share) {
  std::vector<double> seconds = result.call_seconds;
  if (seconds.empty()) return kNotApplicable;
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(seconds.size() - 1));
  std::nth_element(seconds.begin(), seconds.begin() + place, seconds.end());
  return 1e6 * seconds[static_cast<std::size_t>(place)];
}

constexpr std::array kMetrics{
    Metric{"energy", "u^2 s", "integral of |u|^2, the paper's control energy", false,
           [](const Study&, const Outcome& o) { return integral(o, o.result.energy); }},
    Metric{"energy_riemann", "u^2 s", "the same as a right-end Riemann sum with output.quadrature_step", false,
           [](const Study& s, const Outcome& o) {
             return s.output.quadrature_step ? integral(o, o.result.energy_riemann) : kNotApplicable;
           }},
    Metric{"squared_error", "x^2 s", "integral of |x - xi|^2, positions and velocities", false,
           [](const Study&, const Outcome& o) { return integral(o, o.result.squared_error); }},
    Metric{
        "drift_points", "", "training points of a at the end", true,
        [](const Study&, const Outcome& o) { return adaptive(o) ? o.result.belief.drift_points() : kNotApplicable; }},
    Metric{"gain_points", "", "training points of b at the end", true,
           [](const Study&, const Outcome& o) { return adaptive(o) ? o.result.belief.gain_points() : kNotApplicable; }},
    Metric{"new_drift_points", "", "of them, learned in this run", true,
           [](const Study&, const Outcome& o) {
             return adaptive(o) ? o.result.belief.drift_points() - o.start_drift_points : kNotApplicable;
           }},
    Metric{"new_gain_points", "", "of them, learned in this run", true,
           [](const Study&, const Outcome& o) {
             return adaptive(o) ? o.result.belief.gain_points() - o.start_gain_points : kNotApplicable;
           }},
    Metric{"refused_gain_estimates", "", "estimates of b that were not positive and were left out", true,
           [](const Study&, const Outcome& o) {
             return adaptive(o) ? o.result.learning.refused_gain_estimates : kNotApplicable;
           }},
    Metric{"tuning_evaluations", "", "evaluations of the marginal likelihood", true,
           [](const Study&, const Outcome& o) {
             return adaptive(o) ? o.result.learning.tuning_evaluations : kNotApplicable;
           }},
    Metric{"skipped_samples", "", "samples that a process could not take, such as a repetition without noise", true,
           [](const Study&, const Outcome& o) { return if_any(o.result.learning.skipped_samples); }},
    Metric{
        "failed_tunings", "",
        "tunings without a finite marginal likelihood, or at the end of a process over its budget: nothing was changed",
        true, [](const Study&, const Outcome& o) { return if_any(o.result.learning.failed_tunings); }},
    Metric{
        "passing_points", "", "of the new points, taken without a probe", true,
        [](const Study&, const Outcome& o) { return watched(o) ? o.result.learning.passing_samples : kNotApplicable; }},
    Metric{"alarms", "", "of the monitor: the belief was over-confident, its prior was widened", true,
           [](const Study&, const Outcome& o) {
             return watched(o) ? static_cast<double>(o.result.learning.alarms.size()) : kNotApplicable;
           }},
    Metric{"first_alarm", "s", "time of the first of them", false,
           [](const Study&, const Outcome& o) { return first_alarm(o.result); }},
    Metric{"delay", "s",
           "found between an input and what is seen of it, delay and lag together; of several inputs the latest", false,
           [](const Study&, const Outcome& o) { return estimated_delay(o.result); }},
    Metric{"settling_time", "s", "from when on the position stays within 5 % of its way, or 0.05, of the reference",
           false, [](const Study&, const Outcome& o) { return settling_time(o.result); }},
    Metric{"final_angle", "rad or m", "position of joint 1 at the end", false,
           [](const Study&, const Outcome& o) { return last(o) ? last(o)->position[0] : kNotApplicable; }},
    Metric{"final_error", "", "|x - xi| at the end", false,
           [](const Study&, const Outcome& o) { return last(o) ? final_error(*last(o)) : kNotApplicable; }},
    Metric{"peak_input", "unit of u", "largest |u_i| at a control call", false,
           [](const Study&, const Outcome& o) { return last(o) ? peak_input(o.result) : kNotApplicable; }},
    Metric{"latency_median", "us", "of the controller's calls, with output.latency", false,
           [](const Study&, const Outcome& o) { return latency(o.result, 0.5); }},
    Metric{"latency_99", "us", "which 99 % of the calls do not exceed", false,
           [](const Study&, const Outcome& o) { return latency(o.result, 0.99); }},
};

}  // namespace

std::span<const Metric> all_metrics() { return kMetrics; }

}  // namespace bayesctrl
