#include "diagnose/verdict/in_time.hpp"

#include <algorithm>
#include <functional>

#include "diagnose/settings.hpp"

namespace bayesctrl {

namespace {

/// Half the squared errors of free runs in units of the noise, for each of the `parts` of each recording.
std::vector<double> nats_of(const Corrected& model, const std::vector<Measured>& recordings,
                            const std::vector<Trajectory>& paths, const Proof& proof, bool held_out,
                            Eigen::Index parts) {
  const FreeRuns runs = free_runs(model, recordings, paths, proof.horizon, held_out, proof.max_step);
  std::vector<double> list;
  for (std::size_t r = 0; r < recordings.size(); ++r) {
    const Eigen::ArrayXXd errors =
        (recordings[r].position - runs.simulated[r]).array().rowwise() / proof.noise.transpose().array();
    const Eigen::ArrayXXd squares = errors.isNaN().select(0.0, errors.square());
    for (Eigen::Index i = 0; i < parts; ++i) {
      const Eigen::Index from = i * squares.rows() / parts, to = (i + 1) * squares.rows() / parts;
      list.push_back(0.5 * squares.middleRows(from, to - from).sum());
    }
  }
  return list;
}

}  // namespace

std::vector<std::size_t> unconfirmed_in_time(const Corrected& model, const Proof& proof) {
  const auto in_time = [](const Effect& effect) { return effect.form.roles().of_time; };
  if (std::ranges::none_of(model.effects, in_time)) return {};
  const auto improved = [&](const std::vector<Measured>& recordings, bool held_out, std::size_t effect) {
    const std::vector<Trajectory> paths = smooth_all(proof.nominal, recordings, proof.noise);
    Corrected without = model;
    without.effects.erase(without.effects.begin() + static_cast<std::ptrdiff_t>(effect));
    const Eigen::Index parts = model.effects[effect].form.roles().timed ? 1 : 2;
    const std::vector<double> with_it = nats_of(model, recordings, paths, proof, held_out, parts);
    std::vector<double> list = nats_of(without, recordings, paths, proof, held_out, parts);
    std::ranges::transform(list, with_it, list.begin(), std::minus<>());
    return list;
  };
  const auto shows = [](double nats) { return nats > kSettings.verdict.shows_in_time; };
  std::vector<std::size_t> list;
  for (std::size_t e = 0; e < model.effects.size(); ++e) {
    if (!in_time(model.effects[e])) continue;
    double unseen = 0.0;
    if (!proof.held_out.empty()) {
      for (const double nats : improved(proof.held_out, true, e)) unseen += nats;
    }
    if (shows(unseen)) continue;
    const bool recurs = std::ranges::count_if(improved(proof.recordings, false, e), shows) > 1;
    if (!recurs || shows(-unseen)) list.push_back(e);
  }
  return list;
}

}  // namespace bayesctrl
