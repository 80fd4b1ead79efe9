#pragma once

#include <Eigen/Core>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "physics/machine/drive.hpp"
#include "physics/temperature.hpp"

namespace bayesctrl {

/// One recording of a real machine. Rows are samples, columns joints.
struct Measured {
  std::string name;          // the file, for messages
  std::vector<double> time;  // s since its start, increasing
  Eigen::MatrixXd position;  // as the sensor shows it
  Eigen::MatrixXd input;
  double start = 0.0;                       // time stamp of the first sample in the file, s
  bool linear_hold = false;                 // the input runs straight from sample to sample instead of being held
  std::shared_ptr<const FineInput> fine{};  // the inputs of which `input` is the sum, where samples were left out
  std::size_t left_out = 0;                 // rows of the file that were too many to be read, between its pieces
  RecordedTemperature temperature{};

  std::size_t samples() const { return time.size(); }

  /// Without samples yet: for some of them.
  Measured emptied() const { return {name, {}, {}, {}, start, linear_hold, {}, 0, temperature}; }
};

/// Samples [first, last] without a gap.
struct Segment {
  std::size_t recording = 0;
  std::size_t first = 0, last = 0;
  bool opens = false;  // no sample comes before, or none for a while: what the machine did is not known

  std::size_t samples() const { return last - first + 1; }
};

/// Of all recordings.
double samples(const std::vector<Measured>& data);

/// Median time between samples, s.
double sample_period(const std::vector<double>& time);

/// The shortest of all recordings, s.
double shortest_sample_period(const std::vector<Measured>& data);

/// Runs of samples without a gap longer than eight sample periods.
std::vector<Segment> stretches(const Measured& measured, std::size_t recording);

/// Where they begin.
Restarts restarts_of(const Measured& measured);

inline constexpr std::size_t kFewestInWindow = 8;  // samples

/// Windows of `length` seconds laid back to back from the first sample of each stretch; a last one of less than half
/// the length is dropped, as is one of fewer than `least` samples.
std::vector<Segment> windows(const std::vector<Measured>& data, double length, std::size_t least = kFewestInWindow);

/// Why there is no window of `length` seconds, with the lengths of which there are some; empty where there is one.
std::string no_window(const std::vector<Measured>& data, double length);

/// Standard deviation of the sensor's noise in each joint, 1.4826 times the median of sixth
/// (divided) differences of unit weight of neighbouring samples, not below a quantum / sqrt(12). Valid at 15 or more
/// samples per fastest period.
Eigen::VectorXd noise_level(const std::vector<Measured>& data);

/// Root mean square over the joints; 0 of none.
inline double rms(const Eigen::VectorXd& values) {
  return values.size() > 0 ? values.norm() / std::sqrt(static_cast<double>(values.size())) : 0.0;
}

/// Mean frequency of the motion, Hz: RMS speed over RMS position, of the fastest joint.
double mean_frequency(const std::vector<Measured>& data, const Eigen::VectorXd& noise);

/// Of more than `seconds` of samples without a gap, excerpts of `length` seconds and of about that much in all, evenly
/// spread; what lies between them is a gap. Each recording begins with one, and its last sample stays: so does its
/// duration. Of many recordings they are shorter.
std::vector<Measured> excerpts(const std::vector<Measured>& data, double seconds, double length);

/// Seconds of samples without a gap.
double recorded_seconds(const std::vector<Measured>& data);

/// Smallest step between different values, where most values repeat; 0 for values that are not quantised.
double quantum(const Eigen::VectorXd& values);

}  // namespace bayesctrl
