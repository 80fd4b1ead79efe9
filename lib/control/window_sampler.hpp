#pragma once

#include <vector>

#include "control/learner.hpp"
#include "control/window.hpp"

namespace bayesctrl {

/// A sample over a window, with the state at the window's end, as the acceleration carries it on from the middle, and
/// the sum of squared residuals of each joint.
struct WindowSample {
  Derivative derivative;
  StateVector end;
  JointVector passed;  // how far the acceleration's change moves the velocity from the middle to the end
  JointVector rest;
  double freedom = 0.0;  // degrees of, of each joint's residuals
};

/// Measures derivatives over windows of a run's history, as long as the sensor's noise makes necessary, and keeps what
/// their residuals say of that noise.
class WindowSampler {
 public:
  /// Windows of probes and, `in_passing`, those of controlled motion.
  WindowSampler(const DerivativeWindow& window, bool in_passing, int joints, double dt, bool positions_only);

  /// Samples of the shortest window, of the longest, and of the longest that a probe may last.
  int shortest() const { return fits_.front().samples(); }
  int longest() const { return fits_.back().samples(); }
  int longest_probe() const { return longest_probe_; }

  /// Samples of the window of a probe: as many as the noise makes necessary.
  int samples() const { return samples_for(accuracy_, longest_probe_); }

  /// Samples of the shortest window in which the noise leaves an acceleration no more than this variance, up to `most`.
  int samples_for(double variance, int most) const;

  /// Variance of the differences of positions that stand for velocities.
  JointVector difference_variance() const { return 2.0 * noise_ / (dt_ * dt_); }

  /// The state and the acceleration in the middle of a window, the input's own changes within it taken away by what is
  /// believed of b.
  WindowSample operator()(const History& history, long first, int samples, const Timings& timings,
                          const JointMatrix& believed) const;

  /// Variance of the sensor's noise at each joint, from all windows and a further one's squared residuals.
  JointVector noise(const JointVector& rest, double freedom) const;

  /// Variance that the noise leaves of each joint's acceleration over a window of now.
  JointVector acceleration_variance() const { return noise_ * fit_of(samples()).acceleration_variance(); }

  /// Keeps a window's residuals for those that follow.
  void keep(const WindowSample& sample);

 private:
  const WindowFit& fit_of(int samples) const { return fits_[static_cast<std::size_t>(samples - shortest())]; }

  double dt_;
  double accuracy_;  // variance of an acceleration up to which a probe is held, (rad/s^2)^2
  int longest_probe_ = 0;
  std::vector<WindowFit> fits_;  // by samples, from the shortest
  JointVector noise_;            // variance of the sensor's, of each joint, from all windows
  double noise_freedom_ = 0.0;   // and its degrees of freedom
};

}  // namespace bayesctrl
