#include "control/window_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace bayesctrl {

namespace {

constexpr double kNoiseMemory = 40.0;  // degrees of freedom of earlier windows that a new one is weighed against
constexpr double kMostSamples = 500.0;

/// Of a window of so many seconds.
int samples_of(double seconds, double dt) {
  return static_cast<int>(std::min(kMostSamples, std::round(seconds / dt))) + 1;
}

}  // namespace

WindowSampler::WindowSampler(const DerivativeWindow& window, bool in_passing, int joints, double dt,
                             bool positions_only)
    : dt_(dt), accuracy_(std::pow(window.accuracy, 2)), noise_(JointVector::Zero(joints)) {
  const int shortest = positions_only ? 5 : 4;
  const double seconds = in_passing ? std::max(window.longest, window.longest_in_passing) : window.longest;
  longest_probe_ = std::max(shortest, samples_of(window.longest, dt));
  const int longest = std::max(shortest, samples_of(seconds, dt));
  for (int samples = shortest; samples <= longest; ++samples) fits_.emplace_back(samples, dt, positions_only);
}

int WindowSampler::samples_for(double variance, int most) const {
  const double noise = noise_.maxCoeff();
  for (const WindowFit& fit : fits_) {
    if (fit.samples() >= most || noise * fit.acceleration_variance() <= variance) return fit.samples();
  }
  return longest();
}

WindowSample WindowSampler::operator()(const History& history, long first, int samples, const Timings& timings,
                                       const JointMatrix& believed) const {
  const int n = history.joints();
  const WindowFit& fit = fit_of(samples);
  std::vector<InputMotion> acting;
  Derivative measured{StateVector(2 * n), JointVector(n), JointVector(n)};
  StateVector end(2 * n);
  JointVector passed(n), rest(n);
  for (int j = 0; j < n; ++j) {
    InputMotion motion = motion_of_input(history, j, first, samples, dt_, timings[static_cast<std::size_t>(j)]);
    measured.input[j] = motion.mean;
    for (int k = 0; k < samples; ++k) {
      motion.once[k] -= motion.mean * k * dt_;
      motion.twice[k] -= 0.5 * motion.mean * k * k * dt_ * dt_;
    }
    acting.push_back(std::move(motion));
  }
  const int low = (samples - 1) / 2, high = samples / 2;  // around the middle
  const double h = 0.5 * dt_ * (samples - 1);             // from there to the end
  for (int i = 0; i < n; ++i) {
    Eigen::VectorXd q(samples), v(samples);
    for (int k = 0; k < samples; ++k) {
      q[k] = history.seen(first + k)[i];
      v[k] = history.seen(first + k)[n + i];
    }
    double q_back = 0.0, v_back = 0.0, q_end = 0.0, v_end = 0.0;
    for (int j = 0; j < n && believed.size() > 0; ++j) {
      const InputMotion& motion = acting[static_cast<std::size_t>(j)];
      q -= believed(i, j) * motion.twice;
      v -= believed(i, j) * motion.once;
      q_back += 0.5 * believed(i, j) * (motion.twice[low] + motion.twice[high]);
      v_back += 0.5 * believed(i, j) * (motion.once[low] + motion.once[high]);
      q_end += believed(i, j) * motion.twice[samples - 1];
      v_end += believed(i, j) * motion.once[samples - 1];
    }
    const WindowFit::Result result = fit(q, v);
    measured.x[i] = result.position + q_back;
    measured.x[n + i] = result.velocity + v_back;
    measured.acceleration[i] = result.acceleration;
    end[i] = result.position + h * result.velocity + 0.5 * h * h * result.acceleration + q_end;
    end[n + i] = result.velocity + h * result.acceleration + v_end;
    passed[i] = 0.5 * h * h * result.jerk;
    rest[i] = result.rest;
  }
  const double freedom = fit.degrees_of_freedom();
  measured.variance = fit.acceleration_variance() * noise(rest, freedom);
  return {measured, end, passed, rest, freedom};
}

JointVector WindowSampler::noise(const JointVector& rest, double freedom) const {
  if (noise_freedom_ == 0.0) return freedom > 0.0 ? JointVector(rest / freedom) : rest;
  const double weight = std::min(noise_freedom_, kNoiseMemory);
  return (rest + weight * noise_) / (freedom + weight);
}

void WindowSampler::keep(const WindowSample& sample) {
  noise_ = noise(sample.rest, sample.freedom);
  noise_freedom_ += sample.freedom;
}

}  // namespace bayesctrl
