#pragma once

#include <set>

#include "diagnose/search/fits.hpp"
#include "support/recorded_pendulum.hpp"

namespace bayesctrl::testing {

inline Measured six_seconds(const std::vector<Effect>& hidden, std::uint64_t seed) {
  Measured m = record(Machine(kPendulum, hidden), -1.0, seed);
  m.time.resize(600);
  m.position = m.position.topRows(600).eval();
  m.input = m.input.topRows(600).eval();
  return m;
}

/// The pendulum, by default six seconds of it with hidden effects, linearised about its smoothed motion, and no fits so
/// far.
struct RecordedFits {
  RecordedFits(const std::vector<Effect>& hidden, std::vector<std::size_t> allowed, std::uint64_t seed = 61)
      : RecordedFits({six_seconds(hidden, seed)}, std::move(allowed)) {}
  RecordedFits(std::vector<Measured> recorded, std::vector<std::size_t> allowed) : data(std::move(recorded)) {
    options.allowed = std::move(allowed);
    linearise(smooth_all(plant, data, noise));
  }
  RecordedFits(const RecordedFits&) = delete;  // the parts refer to one another

  /// Longest step of the integration.
  double linearise(std::vector<Trajectory> paths) {
    auto next = std::make_shared<Linearisation>();
    next->paths = std::move(paths);
    next->response =
        std::make_unique<LinearResponse>(plant, data, next->paths, noise, windows(data, 2.0), options.fastest_mode);
    next->forcing = std::make_unique<Forcing>(plant, data, next->paths);
    next->dictionary = make_dictionary(*next->response, *next->forcing, options.allowed);
    about = next;
    return fits.about(next);
  }

  std::set<std::string> keys() const {
    std::set<std::string> result;
    for (const Fit* fit : fits.ranked()) result.insert(key(fit->effects));
    return result;
  }

  Plant plant = kPendulum;
  Eigen::VectorXd noise = Eigen::VectorXd::Constant(1, kPendulumNoise);
  std::vector<Measured> data;
  ExplainOptions options;
  std::shared_ptr<Linearisation> about;
  Fits fits{plant, plant, data, options, 3.0};
};

}  // namespace bayesctrl::testing
