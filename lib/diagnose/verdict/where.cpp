#include "diagnose/verdict/where.hpp"

#include <algorithm>
#include <cmath>

#include "diagnose/settings.hpp"
#include "physics/parameters.hpp"

namespace bayesctrl {

namespace {

/// Runs of samples with z above a threshold, merged across gaps of up to `merge` seconds.
std::vector<Interval> above(const std::vector<double>& time, const Eigen::VectorXd& z, double threshold, double merge,
                            std::size_t recording) {
  std::vector<Interval> list;
  double squares = 0.0, count = 0.0;
  bool open = false;
  for (std::size_t k = 0; k < time.size(); ++k) {
    const double size = z[static_cast<Eigen::Index>(k)];
    if (!(size > threshold)) continue;
    if (!open || time[k] - list.back().to > merge) {
      list.push_back({recording, time[k], time[k], 0.0});
      squares = count = 0.0;
      open = true;
    }
    squares += size * size;
    count += 1.0;
    list.back().to = time[k];
    list.back().score = std::sqrt(squares / count);
  }
  return list;
}

}  // namespace

Channel channel_of(const EffectForm& form) {
  constexpr auto kNames = names(Channel{});
  return static_cast<Channel>(std::find(kNames.begin(), kNames.end(), channel(form)) - kNames.begin());
}

std::vector<Interval> significant_times(const Explanation& explanation, const std::vector<Measured>& data,
                                        const std::vector<Trajectory>& smoothed) {
  std::vector<Interval> list;
  const Fit& best = explanation.best().fit;
  for (std::size_t e = 0; e < best.effects.size(); ++e) {
    const EffectForm& form = best.effects[e].form;
    if (!form.roles().timed) continue;
    const auto r = static_cast<std::size_t>(std::max(0, best.effects[e].recording));
    const std::string_view jump = form.law().jump;
    const double deviation = best.deviation(static_cast<int>(e), jump);
    const double size = std::abs(parameter(form, jump)) / std::max(deviation, 1e-300);
    list.push_back({r, form.switch_time(), data[r].time.back(), size});
  }
  if (!list.empty() && best.effects.size() == 1) return list;
  for (std::size_t r = 0; r < data.size(); ++r) {
    const Eigen::VectorXd z =
        (smoothed[r].missing_torque.array().abs() / smoothed[r].torque_sd.array().max(1e-300)).rowwise().maxCoeff();
    for (const Interval& found : above(data[r].time, z, kSettings.verdict.band, kSettings.verdict.merge_torque, r)) {
      if (found.to - found.from > kSettings.verdict.shortest) list.push_back(found);
    }
  }
  if (!list.empty()) return list;
  const Fit& nominal = explanation.without_effects().fit;
  const LinearResponse& response = *explanation.linearisation->response;
  for (std::size_t w = 0; w < response.windows().size(); ++w) {
    const auto rows = static_cast<double>(response.row_count(w));
    const double squares = nominal.residual.segment(response.first_row(w), response.row_count(w)).squaredNorm();
    const double z = (squares - rows) / std::sqrt(2.0 * rows);
    if (z < kSettings.verdict.band) continue;
    const Segment& window = response.windows()[w];
    const std::vector<double>& t = data[window.recording].time;
    if (!list.empty() && list.back().recording == window.recording &&
        t[window.first] - list.back().to < kSettings.verdict.merge_motion) {
      list.back().to = t[window.last];
      list.back().score = std::max(list.back().score, z);
    } else {
      list.push_back({window.recording, t[window.first], t[window.last], z});
    }
  }
  return list;
}

Departure departure(const Measured& measured, const Eigen::MatrixXd& simulated, const Eigen::VectorXd& noise,
                    std::size_t recording) {
  const Eigen::MatrixXd z = ((measured.position - simulated) * noise.cwiseInverse().asDiagonal()).cwiseAbs();
  return {above(measured.time, z.rowwise().maxCoeff(), kSettings.verdict.departed, kSettings.verdict.merge_motion,
                recording),
          (z.colwise().squaredNorm() / static_cast<double>(z.rows())).cwiseSqrt().transpose()};
}

}  // namespace bayesctrl
