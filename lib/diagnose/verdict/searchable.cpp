#include "diagnose/verdict/searchable.hpp"

#include <algorithm>
#include <cmath>

#include "base/format.hpp"
#include "diagnose/motion/decimate.hpp"
#include "diagnose/settings.hpp"

namespace bayesctrl {

std::string too_little(const std::vector<Measured>& data, const Eigen::VectorXd& noise) {
  const double count = samples(data);
  double duration = 0.0;
  for (const Measured& m : data) duration += m.time.back();
  if (count < kSettings.recording.least_samples) return "only " + format(count, 6) + " samples in all";
  if (duration < kSettings.recording.least_duration) return "only " + format(duration, 3) + " s of recording in all";
  double most = 0.0;
  for (const Measured& m : data) {
    for (Eigen::Index j = 0; j < noise.size(); ++j) {
      const Eigen::ArrayXd q = m.position.col(j).array() - m.position.col(j).mean();
      most = std::max(most, std::sqrt(q.square().mean()) / std::max(noise[j], 1e-300));
    }
  }
  if (most < kSettings.recording.least_motion) return "the machine never moves beyond its sensor's noise";
  if (windows(data, kSettings.motion.segment).empty()) {
    const double period = shortest_sample_period(data);
    const bool milliseconds = period > 0.5;  // no mechanics is sampled that slowly
    return milliseconds ? "samples are " + format(period, 3) + " s apart: is the time in milliseconds (scale: 0.001)?"
                        : "no stretch of a second without a gap";
  }
  return "";
}

ExplainOptions search_options(const DiagnosisSpec& spec, const std::vector<Measured>& recordings,
                              const Eigen::VectorXd& noise) {
  const double fastest =
      std::max(kSettings.motion.fastest_mode, kSettings.motion.bandwidth * mean_frequency(recordings, noise));
  return {spec.effects, spec.model.free, kSettings.motion.segment * kSettings.motion.fastest_mode / fastest, fastest};
}

std::vector<Measured> searched_as_recorded(const std::vector<Measured>& recordings) {
  const double affordable = kSettings.recording.whole * shortest_sample_period(recordings);
  return excerpts(recordings, std::min(kSettings.recording.searched, affordable), kSettings.recording.excerpt);
}

std::vector<Measured> thinned(const Plant& plant, const std::vector<Measured>& recordings,
                              const ExplainOptions& options, const Eigen::VectorXd& noise) {
  return decimated(plant, excerpts(recordings, kSettings.recording.searched, kSettings.recording.excerpt), noise,
                   kSettings.motion.samples_per_period * options.fastest_mode);
}

}  // namespace bayesctrl
